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
    auto chain = std::make_unique<Chain>();
    chain->variables = variables;
    for (std::size_t i = 0; i < joints; ++i) {
        JointConstants joint{};
        const double* s = screws.data() + 6 * i;
        for (int c = 0; c < 3; ++c) joint.v[c] = s[c], joint.w[c] = s[3 + c], joint.a[c] = s[c];
        joint.turns = turns[i] != 0;
        if (joint.turns) {
            const double *w = joint.w, *v = joint.v;
            const double along = w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
            const double wv[3] = {w[1] * v[2] - w[2] * v[1], w[2] * v[0] - w[0] * v[2], w[0] * v[1] - w[1] * v[0]};
            for (int c = 0; c < 3; ++c) {
                joint.b[c] = wv[c];
                joint.c[c] = w[c] * along - v[c];
                joint.a[c] = w[c] * along;
            }
        }
        joint.variable = variable[i];
        if (joint.variable < 0 || joint.variable >= variables) throw nb::value_error("variable out of range");
        joint.multiplier = multiplier.data()[i];
        joint.offset = offset.data()[i];
        chain->joints.push_back(joint);
    }
    for (std::size_t link = 0; link < joints + 2; ++link) {
        const double* t = frames.data() + 16 * link;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) chain->frames.push_back(t[4 * i + j]);
        for (int i = 0; i < 3; ++i) chain->frames.push_back(t[4 * i + 3]);
    }
    return chain;
}

std::unique_ptr<View> make_view(int axes, int origin, const std::vector<double>& point, const std::vector<int>& rows,
                                const std::vector<double>& factors) {
    if (point.size() != 3 || rows.empty() || rows.size() > 6 || factors.size() != rows.size())
        throw nb::value_error("a view has one point and one to six rows");
    auto view = std::make_unique<View>();
    view->axes = axes;
    view->origin = origin;
    view->m = (int)rows.size();
    for (int i = 0; i < 3; ++i) view->point[i] = point[i];
    for (int a = 0; a < view->m; ++a) {
        if (rows[a] < 0 || rows[a] > 5) throw nb::value_error("row out of range");
        view->row[a] = rows[a];
        view->factor[a] = factors[a];
    }
    return view;
}

nb::object pose(const Chain& chain, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0);
    double* out = make<double>(rows * 16);
    each((std::int64_t)rows, threads, [&](std::int64_t a, std::int64_t b) { kernels().pose(chain, q.data(), a, b, out); });
    return array(out, {rows, 4, 4});
}

nb::object jacobian(const Chain& chain, const View& view, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), m = view.m, n = chain.variables;
    double* out = make<double>(rows * m * n);
    each((std::int64_t)rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels().jacobian(chain, view, q.data(), a, b, out); });
    return array(out, {rows, m, n});
}

// One configuration into an array that is there already: the shortest way from Python to the kernel and back. The
// narrowest lanes serve a single row best, and give the same bits. False for a q that is not finite.
bool jacobian_one(const Chain& chain, const View& view, const In1& q, const Out2& out) {
    const std::size_t m = view.m, n = chain.variables;
    if (q.shape(0) != n || out.shape(0) != m || out.shape(1) != n) throw nb::value_error("q or out has the wrong shape");
    for (std::size_t j = 0; j < n; ++j)
        if (!std::isfinite(q.data()[j])) return false;
    narrowest().jacobian(chain, view, q.data(), 0, 1, out.data());
    return true;
}

nb::object derivative(const Chain& chain, const View& view, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), m = view.m, n = chain.variables;
    double* out = make<double>(rows * m * n * n);
    each((std::int64_t)rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels().derivative(chain, view, q.data(), a, b, out); });
    return array(out, {rows, m, n, n});
}

nb::object singular_values(const Chain& chain, const View& view, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), s = std::min<std::size_t>(view.m, chain.variables);
    double* out = make<double>(rows * s);
    each((std::int64_t)rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels().decompose(chain, view, q.data(), a, b, out, nullptr, nullptr);
    });
    return array(out, {rows, s});
}

nb::object decompose(const Chain& chain, const View& view, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), m = view.m, n = chain.variables, s = std::min(m, n);
    double *sigma = make<double>(rows * s), *u = make<double>(rows * m * m), *v = make<double>(rows * n * n);
    each((std::int64_t)rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels().decompose(chain, view, q.data(), a, b, sigma, u, v); });
    return nb::make_tuple(array(u, {rows, m, m}), array(sigma, {rows, s}), array(v, {rows, n, n}));
}

nb::object block(const Chain& chain, const View& view, const In2& q, int rank, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), m = view.m, n = chain.variables, s = std::min(m, n);
    if (rank < 0 || rank >= (int)s) throw nb::value_error("rank out of range");
    const std::size_t p = m - rank, r = n - rank;
    double *sigma = make<double>(rows * s), *f = make<double>(rows * p * r), *d = make<double>(rows * p * r * n),
           *u2 = make<double>(rows * m * p), *v2 = make<double>(rows * n * r);
    each((std::int64_t)rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels().block(chain, view, rank, q.data(), a, b, sigma, f, d, u2, v2);
    });
    return nb::make_tuple(array(f, {rows, p, r}), array(d, {rows, p, r, n}), array(u2, {rows, m, p}),
                          array(v2, {rows, n, r}), array(sigma, {rows, s}));
}

nb::object svd(const In3& a, bool vectors, int threads) {
    const std::size_t rows = a.shape(0), m = a.shape(1), n = a.shape(2), s = std::min(m, n);
    if (s == 0 || s > 16) throw nb::value_error("a matrix has 1 to 16 rows or columns on its narrow side");
    double *sigma = make<double>(rows * s), *u = vectors ? make<double>(rows * m * m) : nullptr,
           *v = vectors ? make<double>(rows * n * n) : nullptr;
    each((std::int64_t)rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels().svd((int)m, (int)n, a.data(), from, to, sigma, u, v);
    });
    if (!vectors) return array(sigma, {rows, s});
    return nb::make_tuple(array(u, {rows, m, m}), array(sigma, {rows, s}), array(v, {rows, n, n}));
}

nb::object links(const Chain& chain, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), count = chain.joints.size() + 2;
    double* out = make<double>(rows * count * 16);
    each((std::int64_t)rows, threads, [&](std::int64_t a, std::int64_t b) { kernels().links(chain, q.data(), a, b, out); });
    return array(out, {rows, count, 4, 4});
}

std::vector<std::string> instruction_sets() {
    const char* names[3];
    const int count = available(names, 3);
    return std::vector<std::string>(names, names + count);
}

}  // namespace

void bind_chain(nb::module_& module) {
    nb::class_<Chain>(module, "Chain").def_ro("variables", &Chain::variables);
    nb::class_<View>(module, "View").def_ro("m", &View::m);
    module.def("make_chain", &make_chain, nb::arg("screws"), nb::arg("turns"), nb::arg("frames"), nb::arg("variable"),
               nb::arg("multiplier"), nb::arg("offset"), nb::arg("variables"));
    module.def("make_view", &make_view, nb::arg("axes"), nb::arg("origin"), nb::arg("point"), nb::arg("rows"),
               nb::arg("factors"));
    module.def("pose", &pose, nb::arg("chain"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("jacobian", &jacobian, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("jacobian_one", &jacobian_one, nb::arg("chain"), nb::arg("view"), nb::arg("q"),
               nb::arg("out"));
    module.def("derivative", &derivative, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("singular_values", &singular_values, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("decompose", &decompose, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("block", &block, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("rank"), nb::arg("threads") = 0);
    module.def("svd", &svd, nb::arg("a"), nb::arg("vectors") = true, nb::arg("threads") = 0);
    module.def("links", &links, nb::arg("chain"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("instruction_sets", &instruction_sets);
    module.def("instruction_set", [] { return std::string(kernels().name); });
    module.def("choose_instruction_set", [](const std::string& name) { return choose(name.c_str()); }, nb::arg("name"));
}

}  // namespace rankdrop
