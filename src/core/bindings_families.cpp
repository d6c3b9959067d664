// Which family, and readable bases.
#include "bindings.hpp"

#include "readable.hpp"

namespace rankdrop {
namespace {

// Orthonormal columns (B, m, k) in, readable bases of their spans out.
nb::object readable_bases(const In3& bases) {
    const std::size_t count = bases.shape(0), rows = bases.shape(1), columns = bases.shape(2);
    if (columns == 0 || columns > rows) throw nb::value_error("a basis has one to as many columns as rows");
    double* out = make<double>(count * rows * columns);
    {
        nb::gil_scoped_release release;
        readable((int)rows, (int)columns, bases.data(), (std::int64_t)count, out);
    }
    return array(out, {count, rows, columns});
}

std::unique_ptr<Families> make_families(int variables, const std::vector<double>& m, const std::vector<double>& shift,
                                        const std::vector<double>& a, const std::vector<double>& b,
                                        const std::vector<int>& powers, const std::vector<int>& terms,
                                        const std::vector<int>& equations, const std::vector<int>& corank,
                                        const std::vector<double>& scale) {
    const std::size_t count = shift.size(), n = variables;
    const auto rising = [](const std::vector<int>& starts, std::size_t end) {
        return !starts.empty() && starts.front() == 0 && starts.back() == (int)end && std::is_sorted(starts.begin(), starts.end());
    };
    if (a.size() != count || b.size() != count || m.size() != count * n || powers.size() != count * n || scale.size() != n ||
        !rising(terms, count) || !rising(equations, terms.size() - 1) || equations.size() != corank.size() + 1)
        throw nb::value_error("sizes of the families' arrays do not agree");
    return std::make_unique<Families>(Families{variables, m, shift, a, b, powers, terms, equations, corank, scale});
}

void fit(const Chain& chain, const View& view, const Families& families, int generic) {
    if (families.variables != chain.variables) throw nb::value_error("the families are of another number of joints");
    if (generic < 1 || generic > std::min(view.m, chain.variables)) throw nb::value_error("generic rank out of range");
}

nb::object monitor(const Chain& chain, const View& view, const Families& families, const In2& q, int generic,
                   double singular, double on, double loose, int threads) {
    fit(chain, q);
    fit(chain, view, families, generic);
    const MonitorSettings settings{generic, singular, on, loose};
    const std::size_t rows = q.shape(0), m = view.m, n = chain.variables, s = std::min(m, n);
    const SightingsOutput out{make<double>(rows * s), make<double>(rows * m * m), make<double>(rows * n * n),
                              make<double>(rows), make<double>(rows), make<std::int32_t>(rows),
                              make<std::int32_t>(rows), make<std::int32_t>(rows)};
    each((std::int64_t)rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels().monitor(chain, view, families, settings, q.data(), from, to, out);
    });
    return nb::make_tuple(array(out.sigma, {rows, s}), array(out.rank, {rows}), array(out.family, {rows}),
                          array(out.nearest, {rows}), array(out.residual, {rows}), array(out.u, {rows, m, m}),
                          array(out.v, {rows, n, n}), array(out.distance, {rows}));
}

// One configuration; None for a q that is not finite. As for `jacobian_one`, the narrowest lanes give the same bits.
nb::object monitor_one(const Chain& chain, const View& view, const Families& families, const In1& q, int generic,
                       double singular, double on, double loose) {
    fit(chain, view, families, generic);
    const std::size_t m = view.m, n = chain.variables, s = std::min(m, n);
    if (q.shape(0) != n) throw nb::value_error("q has the wrong shape");
    for (std::size_t j = 0; j < n; ++j)
        if (!std::isfinite(q.data()[j])) return nb::none();
    double residual, distance;
    std::int32_t rank, family, nearest;
    const SightingsOutput out{make<double>(s), make<double>(m * m), nullptr, &residual, &distance, &rank, &family, &nearest};
    narrowest().monitor(chain, view, families, MonitorSettings{generic, singular, on, loose}, q.data(), 0, 1, out);
    return nb::make_tuple(array(out.sigma, {s}), rank, family, nearest, residual, array(out.u, {m, m}), distance);
}

}  // namespace

void bind_families(nb::module_& module) {
    nb::class_<Families>(module, "Families").def_ro("variables", &Families::variables);
    module.def("readable", &readable_bases, nb::arg("bases"));
    module.def("make_families", &make_families, nb::arg("variables"), nb::arg("m"), nb::arg("shift"), nb::arg("a"),
               nb::arg("b"), nb::arg("powers"), nb::arg("terms"), nb::arg("equations"), nb::arg("corank"), nb::arg("scale"));
    module.def("monitor", &monitor, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"), nb::arg("generic"),
               nb::arg("singular"), nb::arg("on"), nb::arg("loose"), nb::arg("threads") = 0);
    module.def("monitor_one", &monitor_one, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"),
               nb::arg("generic"), nb::arg("singular"), nb::arg("on"), nb::arg("loose"));
}

}  // namespace rankdrop
