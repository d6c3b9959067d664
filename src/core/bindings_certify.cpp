// Regions proven free of singularities: enclosures of boxes and balls, one ball by branch and bound.
#include "bindings.hpp"

#include "ball.hpp"

namespace rankdrop {
namespace {

EnclosureSettings make_enclosure(const Chain& chain, const View& view, int rank, double length, const In1& scale,
                                 const In1& arm, double radius, double repeats) {
    if (rank < 1 || rank > std::min(view.m, chain.variables)) throw nb::value_error("rank out of range");
    if (chain.joints.size() > (std::size_t)kMostJoints) throw nb::value_error("too many joints");
    if (view.axes != view.origin || view.axes > (int)chain.joints.size())
        throw nb::value_error("an enclosure is seen from one link");
    if ((int)scale.shape(0) != chain.variables || arm.shape(0) != chain.joints.size())
        throw nb::value_error("one scale for each variable, one reach for each joint");
    EnclosureSettings settings;
    settings.rank = rank, settings.link = view.axes, settings.inverse_length = 1.0 / length;
    settings.slides = view.row[0] < 3, settings.turns = view.row[view.m - 1] > 2;
    settings.radius = radius, settings.repeats = repeats;
    settings.scale = scale.data(), settings.arm = arm.data();
    return settings;
}

// Boxes (half given) or balls around each row of q; the last five arrays are what the bound speaks of.
nb::object enclose(const Chain& chain, const View& view, const In2& q, const nb::object& half, int rank, double length,
                   const In1& scale, const In1& arm, double radius, double repeats, int threads) {
    fit(chain, q);
    const EnclosureSettings settings = make_enclosure(chain, view, rank, length, scale, arm, radius, repeats);
    const std::size_t rows = q.shape(0), n = chain.variables, m = view.m, r = rank, joints = chain.joints.size();
    const double* widths = nullptr;
    if (!half.is_none()) {
        const In2 given = nb::cast<In2>(half);
        if (given.shape(0) != rows || given.shape(1) != n) throw nb::value_error("half-widths have the shape of q");
        widths = given.data();
    }
    EnclosureOutput out;
    auto* free = make<std::int8_t>(rows);
    out.free = free;
    out.radius = make<double>(rows);
    std::fill(free, free + rows, (std::int8_t)0);
    std::fill(out.radius, out.radius + rows, 0.0);
    out.bound = make<double>(rows * r * r), out.sigma = make<double>(rows * r), out.u = make<double>(rows * m * r);
    out.v = make<double>(rows * n * r), out.arm = make<double>(rows * joints);
    each((std::int64_t)rows, threads,
         [&](std::int64_t a, std::int64_t b) { kernels().enclose(chain, view, settings, q.data(), widths, a, b, out); });
    return nb::make_tuple(array(free, {rows}), array(out.radius, {rows}), array(out.bound, {rows, r, r}),
                          array(out.sigma, {rows, r}), array(out.u, {rows, m, r}), array(out.v, {rows, n, r}),
                          array(out.arm, {rows, joints}));
}

// One ball by branch and bound: radius, evaluations, interrupted, and the free boxes (centre, half) where kept.
nb::object ball(const Chain& chain, const View& view, const In1& q, const nb::ndarray<const bool, nb::ndim<1>>& matters,
                int rank, double length, const In1& scale, const In1& arm, double radius, double inner, double repeats,
                double smallest, std::int64_t budget, bool keep) {
    const std::size_t n = chain.variables;
    if (q.shape(0) != n || matters.shape(0) != n) throw nb::value_error("one number for each variable");
    const EnclosureSettings settings = make_enclosure(chain, view, rank, length, scale, arm, radius, repeats);
    Ball search(chain, view, settings, q.data(), matters.data(), radius, inner, smallest, budget, keep);
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
    const std::size_t boxes = found.centre.size() / n;
    double *centre = make<double>(boxes * n), *half = make<double>(boxes * n);
    std::copy(found.centre.begin(), found.centre.end(), centre);
    std::copy(found.half.begin(), found.half.end(), half);
    return nb::make_tuple(found.radius, found.evaluations, found.stopped, array(centre, {boxes, n}), array(half, {boxes, n}));
}

}  // namespace

void bind_certify(nb::module_& module) {
    module.def("enclose", &enclose, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("half").none(), nb::arg("rank"),
               nb::arg("length"), nb::arg("scale"), nb::arg("arm"), nb::arg("radius"), nb::arg("repeats"),
               nb::arg("threads") = 0);
    module.def("ball", &ball, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("matters"), nb::arg("rank"),
               nb::arg("length"), nb::arg("scale"), nb::arg("arm"), nb::arg("radius"), nb::arg("inner"), nb::arg("repeats"),
               nb::arg("smallest"), nb::arg("budget"), nb::arg("keep"));
}

}  // namespace rankdrop
