// Which family, and readable bases.
#include "bindings.hpp"

#include <algorithm>

#include "readable.hpp"
#include "watcher.hpp"

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

std::unique_ptr<Families> make_families(int variables, const std::vector<double>& shift, const std::vector<int>& turns,
                                        const std::vector<int>& turning, const std::vector<double>& m,
                                        const std::vector<int>& angle, const std::vector<double>& a,
                                        const std::vector<double>& b, const std::vector<int>& powers,
                                        const std::vector<int>& terms, const std::vector<int>& equations,
                                        const std::vector<int>& corank, const std::vector<double>& scale,
                                        const std::vector<int>& periodic, const std::vector<int>& coupled,
                                        const std::vector<int>& pins, const std::vector<int>& pinned,
                                        const std::vector<int>& at, const std::vector<double>& values) {
    auto families = std::make_unique<Families>(Families{variables, shift, turns, turning, m, angle, a, b, powers, terms,
                                                        equations, corank, scale, periodic, coupled, pins, pinned, at, values});
    if (!families->finish()) throw nb::value_error("sizes of the families' arrays do not agree");
    return families;
}

std::unique_ptr<MonitorSettings> make_monitor_settings(int generic, double singular, double on, double loose, double start,
                                                       double stop, bool beyond, const std::vector<double>& rates) {
    return std::make_unique<MonitorSettings>(MonitorSettings{generic, singular, on, loose, start, stop, beyond, rates});
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

void spread_points(const Chain& chain, const View& view, Families& families, const MonitorSettings& settings) {
    fit(chain, view, families, settings);
    nb::gil_scoped_release release;
    kernels().spread(chain, view, families, settings);
}

std::unique_ptr<Watcher> make_watcher(const Chain& chain, const View& view, const Families& families,
                                      const MonitorSettings& settings) {
    fit(chain, view, families, settings);
    const bool walks = std::find(families.lengthy.begin(), families.lengthy.end(), 1) != families.lengthy.end();
    return watch(walks, chain, view, families, settings);
}

// One configuration, velocity or none; None where one of them is not finite. One array: sigma, u, the null-space step, q.
nb::object step(Watcher& watcher, const In1& q, const std::optional<In1>& velocity) {
    const std::size_t m = static_cast<std::size_t>(watcher.rows()), n = static_cast<std::size_t>(watcher.variables()),
                      s = std::min(m, n);
    if (q.shape(0) != n || (velocity && velocity->shape(0) != n)) throw nb::value_error("q or velocity has the wrong shape");
    rankdrop_step seen;
    if (!watcher.step(q.data(), velocity ? velocity->data() : nullptr, seen)) return nb::none();
    Result<double> arrays({s + m * m + 2 * n});
    double* next = std::copy_n(seen.sigma, s, arrays.data());
    next = std::copy_n(seen.u, m * m, next);
    next = std::copy_n(seen.null_step, n, next);
    std::copy_n(q.data(), n, next);
    return nb::make_tuple(arrays.give(), seen.rank, seen.corank, seen.family, seen.nearest, seen.residual, seen.distance,
                          seen.approach, seen.scaling, seen.rate_scaling, seen.null_rate);
}

// Of every family at the last step: distance (F), residual (F), and the gradient of the distance by q (F, n).
nb::object apart(const Watcher& watcher) {
    const std::size_t count = static_cast<std::size_t>(watcher.families()), n = static_cast<std::size_t>(watcher.variables());
    Result<double> distance({count}), residual({count}), away({count, n});
    for (std::size_t f = 0; f < count; ++f)
        watcher.family(static_cast<int>(f), distance.data() + f, residual.data() + f, away.data() + f * n);
    return nb::make_tuple(distance.give(), residual.give(), away.give());
}

void fit(const Families& table, const In2& q) {
    if (static_cast<int>(q.shape(1)) != table.variables) throw nb::value_error("q has the wrong number of columns");
}

// Of all equations, whatever family they are of: f (B, e), and with `slopes` their gradients (B, e, n).
nb::object equations(const Families& table, const In2& q, bool slopes, int threads) {
    fit(table, q);
    const std::size_t rows = q.shape(0), count = table.terms.size() - 1, n = q.shape(1);
    Result<double> f({rows, count}), gradients({slopes ? rows : 0, count, n});
    each(rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels(rows).equations(table, q.data(), from, to, f.data(), slopes ? gradients.data() : nullptr);
    });
    if (!slopes) return f.give();
    return nb::make_tuple(f.give(), gradients.give());
}

std::unique_ptr<ZeroSettings> make_zero_settings(int iterations, double step, double still, double enough, double cut,
                                                 const std::vector<double>& along) {
    return std::make_unique<ZeroSettings>(ZeroSettings{iterations, step, still, enough, cut, along});
}

// Common zeros of all equations by Gauss–Newton from starts (B, n): where they ended, and the largest |f| (B) left there.
nb::object zeros(const Families& table, const In2& q, const ZeroSettings& settings, int threads) {
    fit(table, q);
    const std::size_t rows = q.shape(0), n = q.shape(1), count = table.terms.size() - 1;
    if (settings.along.size() % n != 0 || settings.along.size() > n * n) throw nb::value_error("along has shape (n, d), d <= n");
    const std::size_t free = settings.along.empty() ? n : settings.along.size() / n;
    if (count == 0 || std::min(count, free) > kMostEquations) throw nb::value_error("one to 200 equations, or joints that may move");
    Result<double> ends({rows, n}), worst({rows});
    std::copy_n(q.data(), q.size(), ends.data());
    each(rows, threads, [&](std::int64_t from, std::int64_t to) {
        kernels(rows).zeros(table, settings, ends.data(), from, to, worst.data());
    });
    return nb::make_tuple(ends.give(), worst.give());
}

std::unique_ptr<FootSettings> make_foot_settings(int leading, int iterations, int returns, double still, double longest,
                                                 double cut, double flattest, double farthest, const std::vector<double>& target,
                                                 const std::vector<double>& scale, const std::vector<int>& periodic,
                                                 const std::vector<int>& columns, const std::optional<In2>& limits) {
    const std::size_t n = target.size();
    if (scale.size() != n || periodic.size() != n || columns.empty() || columns.size() > n ||
        (limits && (limits->shape(0) != 2 || limits->shape(1) != n)))
        throw nb::value_error("one number for each variable, and at least one that moves");
    for (const int column : columns)
        if (column < 0 || column >= static_cast<int>(n)) throw nb::value_error("column out of range");
    auto settings = std::make_unique<FootSettings>(
        FootSettings{leading, iterations, returns, still, longest, cut, flattest, farthest, target, scale, periodic, columns, {}, {}});
    if (limits) {
        settings->lower.assign(limits->data(), limits->data() + n);
        settings->upper.assign(limits->data() + n, limits->data() + 2 * n);
    }
    return settings;
}

// Where starts (B, n) end: at points of the family that are nearest to the target, as far as Newton's steps tell.
nb::object feet(const Families& table, const In2& q, const FootSettings& settings, int threads) {
    fit(table, q);
    const std::size_t rows = q.shape(0), n = q.shape(1), count = table.terms.size() - 1;
    if (settings.target.size() != n) throw nb::value_error("the settings are of another number of joints");
    if (settings.leading < 1 || static_cast<std::size_t>(settings.leading) > count) throw nb::value_error("leading is out of range");
    if (std::min(count, n) > kMostEquations) throw nb::value_error("at most 200 equations, or joints");
    Result<double> ends({rows, n});
    std::copy_n(q.data(), q.size(), ends.data());
    each(rows, threads, [&](std::int64_t from, std::int64_t to) { kernels(rows).feet(table, settings, ends.data(), from, to); });
    return ends.give();
}

}  // namespace

void bind_families(nb::module_& module) {
    nb::class_<Families>(module, "Families").def_ro("variables", &Families::variables);
    module.def("readable", &readable_bases, nb::arg("bases"));
    module.def("make_families", &make_families, nb::kw_only(), nb::arg("variables"), nb::arg("shift"), nb::arg("turns"),
               nb::arg("turning"), nb::arg("m"), nb::arg("angle"), nb::arg("a"), nb::arg("b"), nb::arg("powers"),
               nb::arg("terms"), nb::arg("equations"), nb::arg("corank"), nb::arg("scale"), nb::arg("periodic"),
               nb::arg("coupled"), nb::arg("pins"), nb::arg("pinned"), nb::arg("at"), nb::arg("values"));
    nb::class_<MonitorSettings>(module, "MonitorSettings")
        .def(nb::new_(&make_monitor_settings), nb::kw_only(), nb::arg("generic"), nb::arg("singular"), nb::arg("on"),
             nb::arg("loose"), nb::arg("start"), nb::arg("stop"), nb::arg("beyond"), nb::arg("rates"));
    module.def("monitor", &monitor, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"),
               nb::arg("settings"), nb::kw_only(), nb::arg("threads") = 0);
    module.def("spread", &spread_points, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("settings"));
    module.def("equations", &equations, nb::arg("families"), nb::arg("q"), nb::kw_only(), nb::arg("slopes") = true,
               nb::arg("threads") = 0);
    nb::class_<ZeroSettings>(module, "ZeroSettings")
        .def(nb::new_(&make_zero_settings), nb::kw_only(), nb::arg("iterations"), nb::arg("step"), nb::arg("still"),
             nb::arg("enough"), nb::arg("cut"), nb::arg("along"));
    module.def("zeros", &zeros, nb::arg("families"), nb::arg("q"), nb::arg("settings"), nb::kw_only(), nb::arg("threads") = 0);
    nb::class_<FootSettings>(module, "FootSettings")
        .def(nb::new_(&make_foot_settings), nb::kw_only(), nb::arg("leading"), nb::arg("iterations"), nb::arg("returns"),
             nb::arg("still"), nb::arg("longest"), nb::arg("cut"), nb::arg("flattest"), nb::arg("farthest"), nb::arg("target"),
             nb::arg("scale"), nb::arg("periodic"), nb::arg("columns"), nb::arg("limits").none());
    module.def("feet", &feet, nb::arg("families"), nb::arg("q"), nb::arg("settings"), nb::kw_only(), nb::arg("threads") = 0);
    nb::class_<Watcher>(module, "Watcher")
        .def(nb::new_(&make_watcher), nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("settings"))
        .def("step", &step, nb::arg("q"), nb::arg("velocity").none())
        .def("apart", &apart);
}

}  // namespace rankdrop
