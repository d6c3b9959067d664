// Which family, and readable bases.
#include "bindings.hpp"

#include "readable.hpp"

namespace rankdrop {
namespace {

// Are the columns orthonormal, to more than single precision? No number that is not finite passes.
bool orthonormal(const In3& bases) {
    const std::size_t rows = bases.shape(1), columns = bases.shape(2);
    for (std::size_t item = 0; item < bases.shape(0); ++item) {
        const double* basis = bases.data() + item * rows * columns;
        for (std::size_t a = 0; a < columns; ++a)
            for (std::size_t b = a; b < columns; ++b) {
                double sum = a == b ? -1.0 : 0.0;
                for (std::size_t i = 0; i < rows; ++i) sum += basis[i * columns + a] * basis[i * columns + b];
                if (!(std::fabs(sum) < 1e-8)) return false;
            }
    }
    return true;
}

// Orthonormal columns (B, m, k) in, readable bases of their spans out.
nb::object readable_bases(const In3& bases) {
    const std::size_t count = bases.shape(0), rows = bases.shape(1), columns = bases.shape(2);
    if (columns == 0 || columns > rows) throw nb::value_error("a basis has one to as many columns as rows");
    if (!orthonormal(bases)) throw nb::value_error("columns of a basis are orthonormal");
    Result<double> out({count, rows, columns});
    {
        nb::gil_scoped_release release;
        readable(static_cast<int>(rows), static_cast<int>(columns), bases.data(), static_cast<std::int64_t>(count), out.data());
    }
    return out.give();
}

std::unique_ptr<Families> make_families(int variables, const std::vector<double>& m, const std::vector<double>& shift,
                                        const std::vector<double>& a, const std::vector<double>& b,
                                        const std::vector<int>& powers, const std::vector<int>& terms,
                                        const std::vector<int>& equations, const std::vector<int>& corank,
                                        const std::vector<double>& scale, const std::vector<int>& periodic,
                                        const std::vector<int>& coupled, const std::vector<int>& pins,
                                        const std::vector<int>& pinned, const std::vector<int>& at,
                                        const std::vector<double>& values) {
    const std::size_t count = shift.size(), n = variables;
    const auto rising = [](const std::vector<int>& starts, std::size_t end) {
        return !starts.empty() && starts.front() == 0 && starts.back() == (int)end && std::is_sorted(starts.begin(), starts.end());
    };
    if (a.size() != count || b.size() != count || m.size() != count * n || powers.size() != count * n || scale.size() != n ||
        !rising(terms, count) || !rising(equations, terms.size() - 1) || equations.size() != corank.size() + 1 ||
        periodic.size() != n || coupled.size() + 1 != terms.size() || pins.size() != equations.size() ||
        !rising(pins, pinned.size()) || at.size() != pinned.size() + 1 || !rising(at, values.size()) ||
        std::any_of(pinned.begin(), pinned.end(), [&](int j) { return j < 0 || j >= variables; }))
        throw nb::value_error("sizes of the families' arrays do not agree");
    return std::make_unique<Families>(Families{variables, m, shift, a, b, powers, terms, equations, corank, scale,
                                               periodic, coupled, pins, pinned, at, values});
}

std::unique_ptr<MonitorSettings> make_monitor_settings(int generic, double singular, double on, double loose) {
    return std::make_unique<MonitorSettings>(MonitorSettings{generic, singular, on, loose});
}

void fit(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings) {
    fit(chain, view);
    if (families.variables != chain.variables) throw nb::value_error("the families are of another number of joints");
    if (settings.generic < 1 || settings.generic > std::min(view.m, chain.variables))
        throw nb::value_error("generic rank out of range");
}

nb::object monitor(const Chain& chain, const View& view, const Families& families, const In2& q,
                   const MonitorSettings& settings, int threads) {
    fit(chain, q);
    fit(chain, view, families, settings);
    const std::size_t rows = q.shape(0), m = static_cast<std::size_t>(view.m),
                      n = static_cast<std::size_t>(chain.variables), s = std::min(m, n);
    Result<double> sigma({rows, s}), u({rows, m, m}), v({rows, n, n}), residual({rows}), distance({rows});
    Result<std::int32_t> rank({rows}), family({rows}), nearest({rows});
    const SightingsOutput out{sigma.data(),    u.data(),    v.data(),      residual.data(),
                              distance.data(), rank.data(), family.data(), nearest.data()};
    each(rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels().monitor(chain, view, families, settings, q.data(), from, to, out);
    });
    return nb::make_tuple(sigma.give(), rank.give(), family.give(), nearest.give(), residual.give(), u.give(), v.give(),
                          distance.give());
}

// One configuration; None for a q that is not finite. As for `jacobian_one`, the narrowest lanes give the same bits.
nb::object monitor_one(const Chain& chain, const View& view, const Families& families, const In1& q,
                       const MonitorSettings& settings) {
    fit(chain, view, families, settings);
    const std::size_t m = static_cast<std::size_t>(view.m), n = static_cast<std::size_t>(chain.variables), s = std::min(m, n);
    if (q.shape(0) != n) throw nb::value_error("q has the wrong shape");
    for (std::size_t j = 0; j < n; ++j)
        if (!std::isfinite(q.data()[j])) return nb::none();
    Result<double> sigma({s}), u({m, m});
    double residual, distance;
    std::int32_t rank, family, nearest;
    const SightingsOutput out{sigma.data(), u.data(), nullptr, &residual, &distance, &rank, &family, &nearest};
    narrowest().monitor(chain, view, families, settings, q.data(), 0, 1, out);
    return nb::make_tuple(sigma.give(), rank, family, nearest, residual, u.give(), distance);
}

}  // namespace

void bind_families(nb::module_& module) {
    nb::class_<Families>(module, "Families").def_ro("variables", &Families::variables);
    module.def("readable", &readable_bases, nb::arg("bases"));
    module.def("make_families", &make_families, nb::kw_only(), nb::arg("variables"), nb::arg("m"), nb::arg("shift"),
               nb::arg("a"), nb::arg("b"), nb::arg("powers"), nb::arg("terms"), nb::arg("equations"), nb::arg("corank"),
               nb::arg("scale"), nb::arg("periodic"), nb::arg("coupled"), nb::arg("pins"), nb::arg("pinned"), nb::arg("at"),
               nb::arg("values"));
    nb::class_<MonitorSettings>(module, "MonitorSettings")
        .def(nb::new_(&make_monitor_settings), nb::kw_only(), nb::arg("generic"), nb::arg("singular"), nb::arg("on"),
             nb::arg("loose"));
    module.def("monitor", &monitor, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"),
               nb::arg("settings"), nb::kw_only(), nb::arg("threads") = 0);
    module.def("monitor_one", &monitor_one, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"),
               nb::arg("settings"));
}

}  // namespace rankdrop
