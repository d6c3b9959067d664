// Regions proven free of singularities: enclosures of boxes and balls, one ball by branch and bound.
#include "bindings.hpp"

#include "ball.hpp"

namespace rankdrop {
namespace {

std::unique_ptr<EnclosureSettings> make_settings(int rank, double length, double radius, double repeats, const In1& scale,
                                                 const In1& arm) {
    return std::make_unique<EnclosureSettings>(
        EnclosureSettings{rank, length, radius, repeats, numbers(scale), numbers(arm)});
}

void fit(const Chain& chain, const View& view, const EnclosureSettings& settings) {
    fit(chain, view);
    if (settings.rank < 1 || settings.rank > std::min(view.m, chain.variables)) throw nb::value_error("rank out of range");
    if (chain.joints.size() > static_cast<std::size_t>(kMostJoints)) throw nb::value_error("too many joints");
    if (view.axes != view.origin || view.axes > static_cast<int>(chain.joints.size()))
        throw nb::value_error("an enclosure is seen from one link");
    if (static_cast<int>(settings.scale.size()) != chain.variables || settings.arm.size() != chain.joints.size())
        throw nb::value_error("one scale for each variable, one reach for each joint");
}

// Boxes (half given) or balls around each row of q; the last five arrays are what the bound speaks of.
nb::object enclose(const Chain& chain, const View& view, const In2& q, const std::optional<In2>& half,
                   const EnclosureSettings& settings, int threads) {
    fit(chain, q);
    fit(chain, view, settings);
    const std::size_t rows = q.shape(0), n = static_cast<std::size_t>(chain.variables),
                      m = static_cast<std::size_t>(view.m), r = static_cast<std::size_t>(settings.rank),
                      joints = chain.joints.size();
    if (half && (half->shape(0) != rows || half->shape(1) != n)) throw nb::value_error("half-widths have the shape of q");
    const double* widths = half ? half->data() : nullptr;
    Result<std::int8_t> free({rows});
    Result<double> radius({rows}), bound({rows, r, r}), sigma({rows, r}), u({rows, m, r}), v({rows, n, r}), arm({rows, joints});
    free.fill(0), radius.fill(0.0);
    EnclosureOutput out;
    out.free = free.data(), out.radius = radius.data(), out.bound = bound.data(), out.sigma = sigma.data();
    out.u = u.data(), out.v = v.data(), out.arm = arm.data();
    each(rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels(rows).enclose(chain, view, settings, q.data(), widths, a, b, out); });
    return nb::make_tuple(free.give(), radius.give(), bound.give(), sigma.give(), u.give(), v.give(), arm.give());
}

// The largest ball around q that one enclosure proves, seen in several ways: which of them, the first of equals, and radius.
nb::object largest_ball(const Chain& chain, const std::vector<const View*>& views,
                        const std::vector<const EnclosureSettings*>& settings, const In1& q) {
    if (views.size() != settings.size() || views.empty()) throw nb::value_error("one view for each of the settings");
    if (q.shape(0) != static_cast<std::size_t>(chain.variables)) throw nb::value_error("one number for each variable");
    for (std::size_t k = 0; k < views.size(); ++k) fit(chain, *views[k], *settings[k]);
    std::size_t best = 0;
    double largest = 0.0;
    for (std::size_t k = 0; k < views.size(); ++k) {
        double radius = 0.0;
        EnclosureOutput out;
        out.radius = &radius, out.above = largest;
        kernels(1).enclose(chain, *views[k], *settings[k], q.data(), nullptr, 0, 1, out);
        if (radius > largest) best = k, largest = radius;
    }
    return nb::make_tuple(best, largest);
}

nb::object array_of(const std::vector<double>& values, std::size_t columns) {
    Result<double> out({values.size() / columns, columns});
    std::copy(values.begin(), values.end(), out.data());
    return out.give();
}

// One ball by branch and bound: radius, evaluations, interrupted, and the free boxes (centre, half) where kept.
nb::object ball(const Chain& chain, const View& view, const In1& q, const Flags& matters, const EnclosureSettings& settings,
                double inner, double enough, double smallest, std::int64_t budget, bool keep) {
    const std::size_t n = static_cast<std::size_t>(chain.variables);
    if (q.shape(0) != n || matters.shape(0) != n) throw nb::value_error("one number for each variable");
    fit(chain, view, settings);
    Ball search(chain, view, settings, q.data(), matters.data(), BallSettings{inner, enough, smallest, budget, keep});
    BallResult found;
    {
        nb::gil_scoped_release release;
        found = search.run([] {
            nb::gil_scoped_acquire acquire;
            if (PyErr_CheckSignals() == 0) return false;
            PyErr_Clear();
            return true;
        });
    }
    return nb::make_tuple(found.radius, found.evaluations, found.stopped, array_of(found.centre, n), array_of(found.half, n));
}

}  // namespace

void bind_certify(nb::module_& module) {
    nb::class_<EnclosureSettings>(module, "EnclosureSettings")
        .def(nb::new_(&make_settings), nb::kw_only(), nb::arg("rank"), nb::arg("length"), nb::arg("radius"),
             nb::arg("repeats"), nb::arg("scale"), nb::arg("arm"));
    module.def("enclose", &enclose, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("half").none(),
               nb::arg("settings"), nb::kw_only(), nb::arg("threads") = 0);
    module.def("largest_ball", &largest_ball, nb::arg("chain"), nb::arg("views"), nb::arg("settings"), nb::arg("q"));
    module.def("ball", &ball, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("matters"), nb::arg("settings"),
               nb::kw_only(), nb::arg("inner"), nb::arg("enough"), nb::arg("smallest"), nb::arg("budget"), nb::arg("keep"));
}

}  // namespace rankdrop
