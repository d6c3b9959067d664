// Searches: to singular configurations of one corank, and to the ones nearest to a given configuration.
#include "bindings.hpp"

namespace rankdrop {
namespace {

SearchSettings make_settings(const Chain& chain, const View& view, int rank, int iterations, double singular, double target,
                             double stationary, std::uint64_t seed, const In1& scale, const nb::object& limits, double tie) {
    const int s = std::min(view.m, chain.variables);
    if (rank < 0 || rank >= s) throw nb::value_error("rank out of range");
    if ((int)scale.shape(0) != chain.variables) throw nb::value_error("one scale for each variable");
    SearchSettings settings;
    settings.rank = rank, settings.iterations = iterations, settings.singular = singular, settings.target = target;
    settings.stationary = stationary, settings.seed = seed, settings.variable_scale = scale.data(), settings.tie = tie;
    if (!limits.is_none()) {
        const In2 both = nb::cast<In2>(limits);
        if (both.shape(0) != 2 || (int)both.shape(1) != chain.variables) throw nb::value_error("limits have shape (2, n)");
        settings.lower = both.data();
        settings.upper = both.data() + chain.variables;
    }
    return settings;
}

// method: 0 block-LM, 1 steepest descent, 2 with AM's rotation. `first` is the number of the first start, so that a
// search in parts is the same as in one go. Rows not begun when Ctrl-C came keep outcome 3 and their start.
nb::object search(const Chain& chain, const View& view, const In2& starts, int rank, int method, int iterations,
                  double singular, double target, double stationary, std::uint64_t seed, std::int64_t first,
                  const In1& scale, const nb::object& limits, double tie, bool history, int threads, double share) {
    fit(chain, starts);
    SearchSettings settings =
        make_settings(chain, view, rank, iterations, singular, target, stationary, seed, scale, limits, tie);
    settings.rotate = method == 2, settings.share = share;
    const std::size_t rows = starts.shape(0), n = chain.variables, s = std::min<std::size_t>(view.m, n), steps = iterations + 1;
    double *q = make<double>(rows * n), *sigma = make<double>(rows * s);
    auto* outcome = make<std::int8_t>(rows);
    auto* count = make<std::int32_t>(rows);
    std::memcpy(q, starts.data(), sizeof(double) * rows * n);
    std::fill(sigma, sigma + rows * s, std::numeric_limits<double>::quiet_NaN());
    std::fill(outcome, outcome + rows, (std::int8_t)kNotRun);
    std::fill(count, count + rows, 0);
    SearchOutput out{q, sigma, outcome, count};
    if (history) {
        out.history = make<double>(rows * steps * s);
        out.turning = make<double>(rows * steps);
        std::fill(out.history, out.history + rows * steps * s, std::numeric_limits<double>::quiet_NaN());
        std::fill(out.turning, out.turning + rows * steps, std::numeric_limits<double>::quiet_NaN());
    }
    volatile bool stop = false;
    bool interrupted = false;
    {
        nb::gil_scoped_release release;
        const auto work = [&](std::int64_t a, std::int64_t b) {
            (method == 0 ? kernels().newton : kernels().descend)(chain, view, settings, starts.data(), a, b, first, out, &stop);
        };
        // lanes are refilled within a chunk: large chunks keep them full, several per thread keep the threads busy
        const std::int64_t chunk = method == 0 ? std::clamp<std::int64_t>((std::int64_t)rows / 16, 64, 1024) : 4;
        if (method == 0 && threads == 1 && (std::int64_t)rows <= kChunk)
            work(0, (std::int64_t)rows);  // some milliseconds: not worth a thread
        else parallel_rows((std::int64_t)rows, chunk, threads, &stop, work, [&] {
            nb::gil_scoped_acquire acquire;
            if (PyErr_CheckSignals() != 0) {
                PyErr_Clear();
                interrupted = true;
            }
            return interrupted;
        });
    }
    nb::object past = nb::none(), turning = nb::none();
    if (history) past = array(out.history, {rows, steps, s}), turning = array(out.turning, {rows, steps});
    return nb::make_tuple(array(q, {rows, n}), array(sigma, {rows, s}), array(outcome, {rows}), array(count, {rows}), past,
                          turning, interrupted);
}

// From points on (or near) the singular set to the ones nearest to `centre`.
nb::object nearest(const Chain& chain, const View& view, const In2& starts, const In1& centre, int rank, int evaluations,
                   double singular, double target, const In1& scale, const nb::object& limits, int threads) {
    fit(chain, starts);
    const int n = chain.variables, s = std::min(view.m, n);
    if (rank < 0 || rank >= s) throw nb::value_error("rank out of range");
    if ((int)centre.shape(0) != n || (int)scale.shape(0) != n) throw nb::value_error("one number for each variable");
    if (std::min(n, (view.m - rank) * (n - rank)) > 16) throw nb::value_error("more than 16 variables and conditions");
    NearestSettings settings;
    settings.rank = rank, settings.evaluations = evaluations, settings.singular = singular, settings.target = target;
    settings.centre = centre.data(), settings.variable_scale = scale.data();
    if (!limits.is_none()) {
        const In2 both = nb::cast<In2>(limits);
        if (both.shape(0) != 2 || (int)both.shape(1) != n) throw nb::value_error("limits have shape (2, n)");
        settings.lower = both.data(), settings.upper = both.data() + n;
    }
    const std::size_t rows = starts.shape(0);
    double *q = make<double>(rows * n), *distance = make<double>(rows), *stationarity = make<double>(rows);
    auto* count = make<std::int32_t>(rows);
    std::memcpy(q, starts.data(), sizeof(double) * rows * n);
    std::fill(distance, distance + rows, std::numeric_limits<double>::infinity());
    std::fill(stationarity, stationarity + rows, std::numeric_limits<double>::infinity());
    std::fill(count, count + rows, 0);
    const NearestOutput out{q, distance, stationarity, count};
    volatile bool stop = false;
    {
        nb::gil_scoped_release release;
        const auto work = [&](std::int64_t a, std::int64_t b) {
            kernels().nearest(chain, view, settings, starts.data(), a, b, out, &stop);
        };
        if (threads == 1 || rows <= 64)
            work(0, (std::int64_t)rows);
        else
            parallel_rows((std::int64_t)rows, 64, threads, &stop, work, [] { return false; });
    }
    return nb::make_tuple(array(q, {rows, (std::size_t)n}), array(distance, {rows}), array(stationarity, {rows}),
                          array(count, {rows}));
}

}  // namespace

void bind_search(nb::module_& module) {
    module.def("search", &search, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("rank"), nb::arg("method"),
               nb::arg("iterations"), nb::arg("singular"), nb::arg("target"), nb::arg("stationary"), nb::arg("seed"),
               nb::arg("first"), nb::arg("scale"), nb::arg("limits").none(), nb::arg("tie"), nb::arg("history"),
               nb::arg("threads"), nb::arg("share") = 0.0);
    module.def("nearest", &nearest, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("centre"),
               nb::arg("rank"), nb::arg("evaluations"), nb::arg("singular"), nb::arg("target"),
               nb::arg("scale"), nb::arg("limits").none(), nb::arg("threads"));
}

}  // namespace rankdrop
