// A chain and what it does at configurations: poses, Jacobians, singular values, the block.
#include "bindings.hpp"
#include "bindings_numpy.hpp"
#include "series.hpp"

#include <unordered_map>

namespace rankdrop {
namespace {

std::unique_ptr<Chain> make_chain(const In2& screws, const std::vector<int>& turns, const In3& frames,
                                  const std::vector<int>& variable, const In1& multiplier, const In1& offset, int variables) {
    const std::size_t joints = screws.shape(0);
    if (screws.shape(1) != 6 || turns.size() != joints || variable.size() != joints || multiplier.shape(0) != joints ||
        offset.shape(0) != joints || frames.shape(0) != joints + 2 || frames.shape(1) != 4 || frames.shape(2) != 4)
        throw nb::value_error("sizes of the chain's arrays do not agree");
    if (variables < 1) throw nb::value_error("a chain has at least one variable");
    auto chain = std::make_unique<Chain>();
    chain->variables = variables;
    for (std::size_t i = 0; i < joints; ++i) {
        if (variable[i] < 0 || variable[i] >= variables) throw nb::value_error("variable out of range");
        chain->joints.push_back(
            joint_constants(screws.data() + 6 * i, turns[i] != 0, variable[i], multiplier.data()[i], offset.data()[i]));
    }
    for (std::size_t link = 0; link < joints + 2; ++link) {
        const double* t = frames.data() + 16 * link;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) chain->frames.push_back(t[4 * i + j]);
        for (int i = 0; i < 3; ++i) chain->frames.push_back(t[4 * i + 3]);
    }
    return chain;
}

std::unique_ptr<View> make_view(const Chain& chain, int axes, int origin, const std::vector<double>& point,
                                const std::vector<int>& rows, const std::vector<double>& factors) {
    if (point.size() != 3 || rows.empty() || rows.size() > 6 || factors.size() != rows.size())
        throw nb::value_error("a view has one point and one to six rows");
    if (axes < 0 || axes >= chain.links() || origin < 0 || origin >= chain.links())
        throw nb::value_error("the chain has no such link");
    auto view = std::make_unique<View>();
    view->links = chain.links();
    view->axes = axes;
    view->origin = origin;
    view->m = static_cast<int>(rows.size());
    for (std::size_t i = 0; i < 3; ++i) view->point[i] = point[i];
    for (std::size_t a = 0; a < rows.size(); ++a) {
        if (rows[a] < 0 || rows[a] > 5) throw nb::value_error("row out of range");
        view->row[a] = rows[a];
        view->factor[a] = factors[a];
    }
    return view;
}

// Sizes of a chain seen through a view.
struct Sizes {
    Sizes(const Chain& chain, const View& view)
        : m(static_cast<std::size_t>(view.m)), n(static_cast<std::size_t>(chain.variables)), s(std::min(m, n)) {}
    std::size_t m, n, s;
};

nb::object pose(const Chain& chain, const In2& q, const nb::object& given, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0);
    Target out(given, {rows, 4, 4});
    out.apart_from(q);
    each(rows, threads, [&](std::int64_t a, std::int64_t b) { kernels(rows).pose(chain, q.data(), a, b, out.data()); });
    return out.give();
}

nb::object jacobian(const Chain& chain, const View& view, const In2& q, const nb::object& given, int threads) {
    fit(chain, view, q);
    const std::size_t rows = q.shape(0);
    const auto [m, n, s] = Sizes(chain, view);
    Target out(given, {rows, m, n});
    out.apart_from(q);
    each(rows, threads, [&](std::int64_t a, std::int64_t b) { kernels(rows).jacobian(chain, view, q.data(), a, b, out.data()); });
    return out.give();
}

// What Python keeps for a robot, by the robot's address: found here in less time than in a dictionary. Both are kept alive by
// whoever calls `keep`, until it calls `let_go` or keeps others for a robot at the same address.
struct Kept {
    nb::object robot;  // a weak reference: another robot may stand at the address of one that is gone
    const Chain* chain;
    const View* world;  // all six rows, world-aligned
};

std::unordered_map<std::uintptr_t, Kept>& kept() {
    static auto* robots = new std::unordered_map<std::uintptr_t, Kept>;  // for good: Python has ended when static objects end
    return *robots;
}

// One configuration, the shortest way from Python to the kernel and back: `kernel` fills an array of the given shape. The
// table for single rows gives the same bits as any other. None for a q or an out that is not finite, contiguous, of doubles
// and of the right shape, and for memory that both share: the long way says what is wrong.
template <class Kernel, std::size_t ND>
PyObject* one(const Chain& chain, PyObject* q, PyObject* out, const Py_ssize_t (&shape)[ND], Kernel kernel) {
    const ArrayFields* from = plain_array(q);
    if (!from || from->nd != 1 || from->dimensions[0] != chain.variables) Py_RETURN_NONE;
    const double* x = reinterpret_cast<const double*>(from->data);
    if (!std::all_of(x, x + chain.variables, [](double value) { return std::isfinite(value); })) Py_RETURN_NONE;
    if (out == Py_None) {
        PyObject* fresh = new_array(shape, static_cast<int>(ND));
        if (fresh) kernel(x, reinterpret_cast<double*>(reinterpret_cast<ArrayFields*>(fresh)->data));
        return fresh;
    }
    const ArrayFields* to = plain_array(out);
    if (!to || !to->writable() || to->nd != static_cast<int>(ND) || !std::equal(shape, shape + ND, to->dimensions)) Py_RETURN_NONE;
    const double *first = reinterpret_cast<const double*>(to->data), *last = first;
    last += std::accumulate(shape, shape + ND, Py_ssize_t{1}, std::multiplies<>());
    if (std::less<>()(x, last) && std::less<>()(first, x + chain.variables)) Py_RETURN_NONE;
    kernel(x, reinterpret_cast<double*>(to->data));
    Py_INCREF(out);
    return out;
}

// The chain and the view of (robot, ..., view or None for the world-aligned one); null where the robot is not kept, or with
// an error set.
std::pair<const Chain*, const View*> kept_of(PyObject* robot, PyObject* given) {
    const auto found = kept().find(reinterpret_cast<std::uintptr_t>(robot));
    if (found == kept().end() || PyWeakref_GetObject(found->second.robot.ptr()) != robot) return {nullptr, nullptr};
    const Chain* chain = found->second.chain;
    if (given == Py_None) return {chain, found->second.world};
    if (!nb::isinstance<View>(given)) {
        PyErr_Format(PyExc_TypeError, "view is a View or None");
        return {nullptr, nullptr};
    }
    const View* view = nb::inst_ptr<View>(given);
    if (view->links != chain->links()) {
        PyErr_Format(PyExc_ValueError, "the view is of a chain with another number of links");
        return {nullptr, nullptr};
    }
    return {chain, view};
}

enum class Entry { pose, jacobian, derivative, sigma };

// (robot, q, out or None, view or None for the world-aligned one) -> an array or None; also where the robot is not kept.
template <Entry WHAT>
PyObject* one_of(PyObject*, PyObject* const* arguments, Py_ssize_t count) {
    if (count != 4) return PyErr_Format(PyExc_TypeError, "robot, q, out and view, not %zd arguments", count);
    const auto [known, seen] = kept_of(arguments[0], arguments[3]);
    if (!known) {
        if (PyErr_Occurred()) return nullptr;
        Py_RETURN_NONE;
    }
    const Chain& chain = *known;
    const View& view = *seen;
    const Py_ssize_t m = view.m, n = chain.variables;
    const auto fill = [&](const auto& shape, auto run) { return one(chain, arguments[1], arguments[2], shape, run); };
    try {
        if constexpr (WHAT == Entry::pose) {
            const Py_ssize_t shape[] = {4, 4};
            return fill(shape, [&](const double* x, double* to) { narrowest().pose(chain, x, 0, 1, to); });
        } else if constexpr (WHAT == Entry::jacobian) {
            const Py_ssize_t shape[] = {m, n};
            return fill(shape, [&](const double* x, double* to) { narrowest().jacobian(chain, view, x, 0, 1, to); });
        } else if constexpr (WHAT == Entry::derivative) {
            const Py_ssize_t shape[] = {m, n, n};
            return fill(shape, [&](const double* x, double* to) { narrowest().derivative(chain, view, x, 0, 1, to); });
        } else {
            const Py_ssize_t shape[] = {std::min(m, n)};
            return fill(shape, [&](const double* x, double* to) {
                narrowest().decompose(chain, view, x, 0, 1, to, nullptr, nullptr);
            });
        }
    } catch (const std::bad_alloc&) {
        return PyErr_NoMemory();
    }
}

// (robot, q, view) -> (u, sigma, v) of one configuration, or None as above.
PyObject* decompose_one(PyObject*, PyObject* const* arguments, Py_ssize_t count) {
    if (count != 3) return PyErr_Format(PyExc_TypeError, "robot, q and view, not %zd arguments", count);
    const auto [known, seen] = kept_of(arguments[0], arguments[2]);
    const ArrayFields* from = known ? plain_array(arguments[1]) : nullptr;
    if (!known && PyErr_Occurred()) return nullptr;
    if (!from || from->nd != 1 || from->dimensions[0] != known->variables) Py_RETURN_NONE;
    const double* x = reinterpret_cast<const double*>(from->data);
    if (!std::all_of(x, x + known->variables, [](double value) { return std::isfinite(value); })) Py_RETURN_NONE;
    const Py_ssize_t m = seen->m, n = known->variables, left[] = {m, m}, values[] = {std::min(m, n)}, right[] = {n, n};
    const auto array = [](const auto& shape) {
        return nb::steal(new_array(shape, static_cast<int>(std::size(shape))));
    };
    const nb::object u = array(left), sigma = array(values), v = array(right);
    if (!u || !sigma || !v) return nullptr;
    const auto data = [](const nb::object& made) {
        return reinterpret_cast<double*>(reinterpret_cast<ArrayFields*>(made.ptr())->data);
    };
    try {
        narrowest().decompose(*known, *seen, x, 0, 1, data(sigma), data(u), data(v));
    } catch (const std::bad_alloc&) {
        return PyErr_NoMemory();
    }
    return PyTuple_Pack(3, u.ptr(), sigma.ptr(), v.ptr());
}

using FastCall = PyObject* (*)(PyObject*, PyObject* const*, Py_ssize_t);

// A function that takes its arguments as they come: naming and converting them would cost as much as what it does.
template <auto FUNCTION>
void define(nb::module_& module, const char* name) {
    static PyMethodDef method{name, reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(static_cast<FastCall>(FUNCTION))),
                              METH_FASTCALL, nullptr};
    module.attr(name) = nb::steal(PyCFunction_NewEx(&method, nullptr, nullptr));
}

nb::object derivative(const Chain& chain, const View& view, const In2& q, const nb::object& given, int threads) {
    fit(chain, view, q);
    const std::size_t rows = q.shape(0);
    const auto [m, n, s] = Sizes(chain, view);
    Target out(given, {rows, m, n, n});
    out.apart_from(q);
    each(rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels(rows).derivative(chain, view, q.data(), a, b, out.data()); });
    return out.give();
}

nb::object singular_values(const Chain& chain, const View& view, const In2& q, const nb::object& given, int threads) {
    fit(chain, view, q);
    const std::size_t rows = q.shape(0);
    Target out(given, {rows, Sizes(chain, view).s});
    out.apart_from(q);
    each(rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels(rows).decompose(chain, view, q.data(), a, b, out.data(), nullptr, nullptr);
    });
    return out.give();
}

nb::object decompose(const Chain& chain, const View& view, const In2& q, int threads) {
    fit(chain, view, q);
    const std::size_t rows = q.shape(0);
    const auto [m, n, s] = Sizes(chain, view);
    Result<double> sigma({rows, s}), u({rows, m, m}), v({rows, n, n});
    each(rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels(rows).decompose(chain, view, q.data(), a, b, sigma.data(), u.data(), v.data());
    });
    return nb::make_tuple(u.give(), sigma.give(), v.give());
}

nb::object block(const Chain& chain, const View& view, const In2& q, int rank, int threads) {
    fit(chain, view, q);
    const std::size_t rows = q.shape(0);
    const auto [m, n, s] = Sizes(chain, view);
    if (rank < 0 || rank >= static_cast<int>(s)) throw nb::value_error("rank out of range");
    const std::size_t kept = static_cast<std::size_t>(rank), p = m - kept, r = n - kept;
    Result<double> sigma({rows, s}), f({rows, p, r}), d({rows, p, r, n}), u2({rows, m, p}), v2({rows, n, r});
    each(rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels(rows).block(chain, view, rank, q.data(), a, b, {sigma.data(), f.data(), d.data(), u2.data(), v2.data()});
    });
    return nb::make_tuple(f.give(), d.give(), u2.give(), v2.give(), sigma.give());
}

nb::object svd(const In3& a, bool vectors, int threads) {
    const std::size_t rows = a.shape(0), m = a.shape(1), n = a.shape(2), s = std::min(m, n);
    if (s == 0 || s > 16) throw nb::value_error("a matrix has 1 to 16 rows or columns on its narrow side");
    if (std::max(m, n) > 4096) throw nb::value_error("a matrix has at most 4096 rows or columns");
    // comparisons with what is not a number order nothing: the values of such a matrix would look like those of a sound one
    if (!std::all_of(a.data(), a.data() + a.size(), [](double x) { return std::isfinite(x); }))
        throw nb::value_error("matrices are finite");
    Result<double> sigma({rows, s}), u({vectors ? rows : 0, m, m}), v({vectors ? rows : 0, n, n});
    each(rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels().svd(static_cast<int>(m), static_cast<int>(n), a.data(), from, to, sigma.data(),
                      vectors ? u.data() : nullptr, vectors ? v.data() : nullptr);
    });
    if (!vectors) return sigma.give();
    return nb::make_tuple(u.give(), sigma.give(), v.give());
}

nb::object links(const Chain& chain, const In2& q, const nb::object& given, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0);
    Target out(given, {rows, static_cast<std::size_t>(chain.links()), 4, 4});
    out.apart_from(q);
    each(rows, threads, [&](std::int64_t a, std::int64_t b) { kernels(rows).links(chain, q.data(), a, b, out.data()); });
    return out.give();
}

std::vector<std::string> instruction_sets() {
    return available();
}

// Screws (joints, 6) along motions (d, joints): (order + 1, d, joints, 6).
nb::object series(const In2& screws, const In2& rates, int axes, int origin, int order) {
    const std::size_t joints = screws.shape(0), motions = rates.shape(0);
    if (screws.shape(1) != 6 || rates.shape(1) != joints || axes < 0 || origin < 0 || order < 0 || order > 64)
        throw nb::value_error("sizes of screws and rates do not agree");
    Result<double> out({static_cast<std::size_t>(order) + 1, motions, joints, 6});
    screw_series(screws.data(), rates.data(), motions, joints, static_cast<std::size_t>(axes), static_cast<std::size_t>(origin),
                 static_cast<std::size_t>(order), out.data());
    return out.give();
}

}  // namespace

void bind_chain(nb::module_& module) {
    nb::class_<Chain>(module, "Chain").def_ro("variables", &Chain::variables);
    nb::class_<View>(module, "View").def_ro("m", &View::m);
    module.def("series", &series, nb::arg("screws"), nb::arg("rates"), nb::arg("axes"), nb::arg("origin"), nb::arg("order"));
    module.def("make_chain", &make_chain, nb::kw_only(), nb::arg("screws"), nb::arg("turns"), nb::arg("frames"), nb::arg("variable"),
               nb::arg("multiplier"), nb::arg("offset"), nb::arg("variables"));
    module.def("make_view", &make_view, nb::arg("chain"), nb::kw_only(), nb::arg("axes"), nb::arg("origin"), nb::arg("point"),
               nb::arg("rows"), nb::arg("factors"));
    module.def("pose", &pose, nb::arg("chain"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("jacobian", &jacobian, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    define<&one_of<Entry::pose>>(module, "pose_one");
    define<&one_of<Entry::jacobian>>(module, "jacobian_one");
    define<&one_of<Entry::derivative>>(module, "derivative_one");
    define<&one_of<Entry::sigma>>(module, "sigma_one");
    define<&decompose_one>(module, "decompose_one");
    module.def("keep", [](nb::handle robot, const Chain& chain, const View& world) {
        fit(chain, world);
        nb::object reference = nb::steal(PyWeakref_NewRef(robot.ptr(), nullptr));
        if (!reference) nb::raise_python_error();
        kept()[reinterpret_cast<std::uintptr_t>(robot.ptr())] = {std::move(reference), &chain, &world};
    }, nb::arg("robot"), nb::arg("chain"), nb::arg("world"));
    module.def("let_go", [](std::uintptr_t robot) { kept().erase(robot); }, nb::arg("robot"));
    module.def("derivative", &derivative, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("singular_values", &singular_values, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("decompose", &decompose, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("block", &block, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("rank"), nb::arg("threads") = 0);
    module.def("svd", &svd, nb::arg("a"), nb::arg("vectors") = true, nb::arg("threads") = 0);
    module.def("links", &links, nb::arg("chain"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("threads_kept", &threads_kept);
    module.def("instruction_sets", &instruction_sets);
    module.def("instruction_set", [] { return std::string(kernels().name); });
    module.def("choose_instruction_set", [](const std::string& name) { return choose(name); }, nb::arg("name"));
}

}  // namespace rankdrop
