// Newton's method towards poses of the tip and back to where a task began, poses between given ones, and rows of numbers
// from text.
#include "bindings.hpp"

#include "aim.hpp"
#include "number_rows.hpp"

namespace rankdrop {
namespace {

std::unique_ptr<AimSettings> new_aim(const std::vector<int>& rows, double length, const std::vector<double>& point, bool with_tip,
                                     int free, int heading, const std::vector<double>& joints) {
    if (rows.empty() || rows.size() > 6 || point.size() != 3) throw nb::value_error("an aim has one point and one to six rows");
    for (const int row : rows)
        if (row < 0 || row > 5) throw nb::value_error("row out of range");
    if (free < -1 || free > 2 || heading < -1 || heading > 2) throw nb::value_error("axis out of range");
    return std::make_unique<AimSettings>(AimSettings{rows, length, {point[0], point[1], point[2]}, with_tip, free, heading, joints});
}

// Sizes that agree: one pose for each row of q, as many rows as the view has, one scale for each joint.
Aim fitted(const Chain& chain, const View& view, const AimSettings& settings, const In2& q) {
    fit(chain, view, q);
    fit(chain, settings.joints, {});
    if (view.m != static_cast<int>(settings.rows.size())) throw nb::value_error("the view has another number of rows");
    return {chain, view, settings};
}

void fit_poses(const In3& poses, std::size_t rows) {
    if (poses.shape(0) != rows || poses.shape(1) != 4 || poses.shape(2) != 4)
        throw nb::value_error("there is one pose (4, 4) for each configuration");
}

nb::object errors_of_aim(const Chain& chain, const AimSettings& settings, const In3& poses, const In2& q) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), m = settings.rows.size();
    fit_poses(poses, rows);
    Result<double> out({rows, m});
    each(rows, 0, [&](std::int64_t a, std::int64_t b) {
        const std::size_t begin = static_cast<std::size_t>(a), count = static_cast<std::size_t>(b - a);
        std::vector<double> now(16 * count);
        kernels(count).pose(chain, q.data() + begin * q.shape(1), 0, b - a, now.data());
        aim_errors(settings, now.data(), poses.data() + 16 * begin, count, out.data() + begin * m);
    });
    return out.give();
}

nb::object steps_of_aim(const Chain& chain, const View& view, const AimSettings& settings, const In2& q, const In2& errors) {
    const Aim aim = fitted(chain, view, settings, q);
    const std::size_t rows = q.shape(0), n = q.shape(1), m = aim.m();
    if (errors.shape(0) != rows || errors.shape(1) != m) throw nb::value_error("there is one error for each configuration");
    if (!std::all_of(q.data(), q.data() + q.size(), [](double x) { return std::isfinite(x); }))
        throw nb::value_error("configurations are finite");
    Result<double> out({rows, n});
    each(rows, 0, [&](std::int64_t a, std::int64_t b) {
        const std::size_t begin = static_cast<std::size_t>(a), count = static_cast<std::size_t>(b - a);
        aim_steps(aim, q.data() + begin * n, errors.data() + begin * m, nullptr, count, out.data() + begin * n);
    });
    return out.give();
}

nb::object newton_of_aim(const Chain& chain, const View& view, const AimSettings& settings, const In3& poses, const In2& q,
                         double close, int rounds, bool far) {
    const Aim aim = fitted(chain, view, settings, q);
    const std::size_t rows = q.shape(0), n = q.shape(1);
    fit_poses(poses, rows);
    Result<double> ends({rows, n});
    Result<std::int64_t> when({rows});
    std::copy_n(q.data(), rows * n, ends.data());
    each(rows, 0, [&](std::int64_t a, std::int64_t b) {
        const std::size_t begin = static_cast<std::size_t>(a), count = static_cast<std::size_t>(b - a);
        aim_newton(aim, {close, rounds, far}, poses.data() + 16 * begin, count, ends.data() + begin * n, when.data() + begin);
    });
    return nb::make_tuple(ends.give(), when.give());
}

std::unique_ptr<DisplacementSettings> new_displacement(const std::vector<int>& rows, const std::vector<double>& row_scale,
                                                       const std::vector<double>& joints, const std::vector<double>& point,
                                                       const In2& axes, const In2& home) {
    if (rows.empty() || rows.size() > 6 || row_scale.size() != rows.size() || point.size() != 3)
        throw nb::value_error("a displacement has one point and one to six rows, each with its scale");
    for (const int row : rows)
        if (row < 0 || row > 5) throw nb::value_error("row out of range");
    if (axes.shape(0) != 3 || axes.shape(1) != 3 || home.shape(0) != 4 || home.shape(1) != 4)
        throw nb::value_error("axes are (3, 3), home is (4, 4)");
    auto settings = std::make_unique<DisplacementSettings>();
    settings->rows = rows, settings->row_scale = row_scale, settings->joints = joints;
    std::copy_n(point.data(), 3, settings->point);
    std::copy_n(axes.data(), 9, &settings->axes[0][0]);
    std::copy_n(home.data(), 16, settings->home);
    return settings;
}

nb::object back_to_start(const Chain& chain, const View& six, const DisplacementSettings& settings, const In2& q, double weak,
                         double longest, double still, int rounds) {
    fit(chain, six, q);
    fit(chain, settings.joints, {});
    if (six.m != 6) throw nb::value_error("the view has all six rows");
    const std::size_t rows = q.shape(0), n = q.shape(1);
    Result<double> ends({rows, n}), off({rows});
    std::copy_n(q.data(), rows * n, ends.data());
    each(rows, 0, [&](std::int64_t a, std::int64_t b) {
        const std::size_t begin = static_cast<std::size_t>(a), count = static_cast<std::size_t>(b - a);
        displacement_back(chain, six, settings, {weak, longest, still, rounds}, count, ends.data() + begin * n, off.data() + begin);
    });
    return nb::make_tuple(ends.give(), off.give());
}

nb::object poses_between(const In3& poses, const In1& places) {
    if (poses.shape(0) == 0) throw nb::value_error("there is no pose");
    fit_poses(poses, poses.shape(0));
    if (!std::all_of(places.data(), places.data() + places.size(), [](double x) { return std::isfinite(x); }))
        throw nb::value_error("places are finite");
    Result<double> out({places.shape(0), 4, 4});
    each(places.shape(0), 0, [&](std::int64_t a, std::int64_t b) {
        const std::size_t begin = static_cast<std::size_t>(a), count = static_cast<std::size_t>(b - a);
        poses_at(poses.data(), poses.shape(0), places.data() + begin, count, out.data() + 16 * begin);
    });
    return out.give();
}

// (rows, columns) of a text of plain numbers, or None.
nb::object rows_of_text(const nb::str& text, const std::string& separator, std::size_t columns) {
    if (separator.size() != 1 || columns == 0) throw nb::value_error("a separator is one character, and there is a column");
    Py_ssize_t size = 0;
    const char* begin = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
    if (!begin) {  // half of a pair of surrogates: no number
        PyErr_Clear();
        return nb::none();
    }
    std::vector<double> values;
    if (!read_rows(begin, begin + size, separator[0], columns, values)) return nb::none();
    Result<double> out({values.size() / columns, columns});
    std::copy(values.begin(), values.end(), out.data());
    return out.give();
}

}  // namespace

void bind_aim(nb::module_& module) {
    nb::class_<AimSettings>(module, "AimSettings");
    module.def("make_aim", &new_aim, nb::kw_only(), nb::arg("rows"), nb::arg("length"), nb::arg("point"), nb::arg("with_tip"),
               nb::arg("free"), nb::arg("heading"), nb::arg("joints"));
    module.def("aim_errors", &errors_of_aim, nb::arg("chain"), nb::arg("aim"), nb::arg("poses"), nb::arg("q"));
    module.def("aim_steps", &steps_of_aim, nb::arg("chain"), nb::arg("view"), nb::arg("aim"), nb::arg("q"), nb::arg("errors"));
    module.def("aim_newton", &newton_of_aim, nb::arg("chain"), nb::arg("view"), nb::arg("aim"), nb::arg("poses"), nb::arg("q"),
               nb::kw_only(), nb::arg("close"), nb::arg("rounds"), nb::arg("far"));
    nb::class_<DisplacementSettings>(module, "Displacement");
    module.def("make_displacement", &new_displacement, nb::kw_only(), nb::arg("rows"), nb::arg("row_scale"), nb::arg("joints"),
               nb::arg("point"), nb::arg("axes"), nb::arg("home"));
    module.def("back_to_start", &back_to_start, nb::arg("chain"), nb::arg("six"), nb::arg("displacement"), nb::arg("q"),
               nb::kw_only(), nb::arg("weak"), nb::arg("longest"), nb::arg("still"), nb::arg("rounds"));
    module.def("rows_of_text", &rows_of_text, nb::arg("text"), nb::arg("separator"), nb::arg("columns"));
    module.def("poses_at", &poses_between, nb::arg("poses"), nb::arg("places"));
}

}  // namespace rankdrop
