// A chain and what it does at configurations: poses, Jacobians, singular values, the block.
#include "bindings.hpp"

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

// The memory of an array while it is looked at. nanobind's own view of an array costs as much as a Jacobian.
class Borrowed {
  public:
    Borrowed(nb::handle array, int flags) { held_ = PyObject_GetBuffer(array.ptr(), &buffer_, flags | PyBUF_FORMAT) == 0; }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    ~Borrowed() {
        if (held_)
            PyBuffer_Release(&buffer_);
        else
            PyErr_Clear();  // not contiguous, or no buffer: whoever asked is told by has()
    }

    bool has(std::initializer_list<std::size_t> shape) const {
        return held_ && std::strcmp(buffer_.format, "d") == 0 && static_cast<std::size_t>(buffer_.ndim) == shape.size() &&
               std::equal(shape.begin(), shape.end(), buffer_.shape,
                          [](std::size_t wanted, Py_ssize_t there) { return static_cast<Py_ssize_t>(wanted) == there; });
    }

    double* data() const { return static_cast<double*>(buffer_.buf); }

  private:
    Py_buffer buffer_;
    bool held_;
};

// One configuration into an array that is there already: the shortest way from Python to the kernel and back. The
// narrowest lanes serve a single row best, and give the same bits. False for a q or an out that is not finite, contiguous,
// of doubles and of the right shape: the long way says what is wrong.
bool jacobian_one(const Chain& chain, const View& view, nb::handle q, nb::handle out) {
    fit(chain, view);
    const auto [m, n, s] = Sizes(chain, view);
    const Borrowed from(q, PyBUF_C_CONTIGUOUS), to(out, PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE);
    if (!from.has({n}) || !to.has({m, n})) return false;
    if (!std::all_of(from.data(), from.data() + n, [](double value) { return std::isfinite(value); })) return false;
    narrowest().jacobian(chain, view, from.data(), 0, 1, to.data());
    return true;
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

}  // namespace

void bind_chain(nb::module_& module) {
    nb::class_<Chain>(module, "Chain").def_ro("variables", &Chain::variables);
    nb::class_<View>(module, "View").def_ro("m", &View::m);
    module.def("make_chain", &make_chain, nb::kw_only(), nb::arg("screws"), nb::arg("turns"), nb::arg("frames"), nb::arg("variable"),
               nb::arg("multiplier"), nb::arg("offset"), nb::arg("variables"));
    module.def("make_view", &make_view, nb::arg("chain"), nb::kw_only(), nb::arg("axes"), nb::arg("origin"), nb::arg("point"),
               nb::arg("rows"), nb::arg("factors"));
    module.def("pose", &pose, nb::arg("chain"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("jacobian", &jacobian, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("out").none() = nb::none(), nb::kw_only(),
               nb::arg("threads") = 0);
    module.def("jacobian_one", &jacobian_one, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("out"));
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
