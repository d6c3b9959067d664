// Searches: to singular configurations of one corank, and to the ones nearest to a given configuration.
#include "bindings.hpp"

#include "mixture.hpp"

namespace rankdrop {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN(), kFar = std::numeric_limits<double>::infinity();

std::unique_ptr<SearchSettings> make_search_settings(int method, int rank, int iterations, double singular, double target,
                                                     double stationary, std::uint64_t seed, const In1& scale,
                                                     const std::optional<In2>& limits, double tie, double share,
                                                     int kicks) {
    if (method < 0 || method > 2) throw nb::value_error("method is 0 (block-LM), 1 (descent) or 2 (with AM's rotation)");
    if (iterations < 0 || iterations > 1'000'000) throw nb::value_error("iterations are 0 … 1000000");
    if (kicks < 0 || kicks > 1000) throw nb::value_error("kicks are 0 … 1000");
    auto settings = std::make_unique<SearchSettings>();
    settings->method = static_cast<Method>(method);
    settings->rank = rank, settings->iterations = iterations, settings->seed = seed, settings->tie = tie,
    settings->share = share, settings->kicks = kicks;
    settings->singular = singular, settings->target = target, settings->stationary = stationary;
    settings->scale = numbers(scale);
    take_limits(limits, settings->lower, settings->upper);
    return settings;
}

// `first` is the number of the first start, so that a search in parts is the same as in one go. Rows not begun when Ctrl-C
// came keep outcome 3 and their start.
nb::object search(const Chain& chain, const View& view, const In2& starts, const SearchSettings& settings,
                  std::int64_t first, bool history, int threads) {
    fit(chain, view, starts);
    fit(chain, settings.scale, settings.lower);
    const std::size_t rows = starts.shape(0), n = static_cast<std::size_t>(chain.variables),
                      s = std::min(static_cast<std::size_t>(view.m), n),
                      steps = static_cast<std::size_t>(settings.iterations) + 1;
    if (settings.rank < 0 || settings.rank >= static_cast<int>(s)) throw nb::value_error("rank out of range");
    Result<double> q({rows, n}), sigma({rows, s}), past({history ? rows : 0, steps, s}), turning({history ? rows : 0, steps});
    Result<std::int8_t> outcome({rows});
    Result<std::int32_t> count({rows});
    if (rows > 0) std::memcpy(q.data(), starts.data(), sizeof(double) * rows * n);
    sigma.fill(kUnknown), past.fill(kUnknown), turning.fill(kUnknown), outcome.fill(kNotRun), count.fill(0);
    SearchOutput out{q.data(), sigma.data(), outcome.data(), count.data()};
    if (history) out.history = past.data(), out.turning = turning.data();
    const bool newton = settings.method == Method::newton;
    std::atomic<bool> stop{false};
    bool interrupted = false;
    {
        nb::gil_scoped_release release;
        const auto work = [&](std::int64_t a, std::int64_t b) {
            (newton ? kernels().newton : kernels().descend)(chain, view, settings, starts.data(), a, b, first, out, stop);
        };
        // lanes are refilled within a chunk: large chunks keep them full, several per thread keep the threads busy
        const auto count_of = static_cast<std::int64_t>(rows);
        const std::int64_t chunk = newton ? std::clamp<std::int64_t>(threads == 1 ? count_of : count_of / 16, 64, 4096) : 4;
        share({count_of, chunk, threads}, stop, work, [&] {
            nb::gil_scoped_acquire acquire;
            if (PyErr_CheckSignals() != 0) {
                PyErr_Clear();
                interrupted = true;
            }
            return interrupted;
        });
    }
    return nb::make_tuple(q.give(), sigma.give(), outcome.give(), count.give(), history ? past.give() : nb::none(),
                          history ? turning.give() : nb::none(), interrupted);
}

std::unique_ptr<NearestSettings> make_nearest_settings(int rank, int evaluations, double singular, double target,
                                                       const In1& centre, const In1& scale,
                                                       const std::optional<In2>& limits, double still, bool polish) {
    auto settings = std::make_unique<NearestSettings>();
    settings->still = still, settings->polish = polish;
    settings->rank = rank, settings->evaluations = evaluations, settings->singular = singular, settings->target = target;
    settings->centre = numbers(centre), settings->scale = numbers(scale);
    take_limits(limits, settings->lower, settings->upper);
    return settings;
}

// From points on (or near) the singular set to the ones nearest to a configuration.
nb::object nearest(const Chain& chain, const View& view, const In2& starts, const NearestSettings& settings, int threads) {
    fit(chain, view, starts);
    fit(chain, settings.scale, settings.lower);
    const int variables = chain.variables, rank = settings.rank;
    if (rank < 0 || rank >= std::min(view.m, variables)) throw nb::value_error("rank out of range");
    if (static_cast<int>(settings.centre.size()) != variables) throw nb::value_error("one number for each variable");
    if (std::min(variables, (view.m - rank) * (variables - rank)) > 16)
        throw nb::value_error("more than 16 variables and conditions");
    const std::size_t rows = starts.shape(0), n = static_cast<std::size_t>(variables);
    Result<double> q({rows, n}), distance({rows}), stationarity({rows});
    Result<std::int32_t> count({rows});
    if (rows > 0) std::memcpy(q.data(), starts.data(), sizeof(double) * rows * n);
    distance.fill(kFar), stationarity.fill(kFar), count.fill(0);
    const NearestOutput out{q.data(), distance.data(), stationarity.data(), count.data()};
    const std::atomic<bool> stop{false};
    each(rows, threads, [&](std::int64_t a, std::int64_t b) {
        kernels().nearest(chain, view, settings, starts.data(), a, b, out, stop);
    });
    return nb::make_tuple(q.give(), distance.give(), stationarity.give(), count.give());
}

// From anywhere to feet on the singular set, of a configuration, where one freedom of all six is lost by joints that move
// one variable each.
nb::object set_feet(const Chain& chain, const View& view, const In2& starts, const In1& centre, const In1& scale,
                    const In1& turn, double farthest) {
    fit(chain, view, starts);
    SetFeetSettings settings;
    settings.centre = numbers(centre), settings.scale = numbers(scale), settings.turn = numbers(turn);
    settings.farthest = farthest;
    const std::size_t rows = starts.shape(0), n = static_cast<std::size_t>(chain.variables);
    if (settings.centre.size() != n || settings.scale.size() != n || settings.turn.size() != n)
        throw nb::value_error("one number for each variable");
    bool plain = view.m == 6 && n >= 6 && n <= 20 && chain.joints.size() == n && rows <= 1'000'000;
    for (std::size_t a = 0; plain && a < 6; ++a)
        plain = view.row[a] == static_cast<int>(a) && view.factor[a] == view.factor[a < 3 ? 0 : 3];
    for (std::size_t i = 0; plain && i < n; ++i) plain = chain.joints[i].variable == static_cast<int>(i);
    if (!plain || view.factor[3] != 1.0) throw nb::value_error("all six rows of six to twenty joints, in order, one for each variable");
    Result<double> q({rows, n});
    Result<std::int8_t> met({rows});
    Result<double> far({rows});
    if (rows > 0) std::memcpy(q.data(), starts.data(), sizeof(double) * rows * n);
    {
        nb::gil_scoped_release release;
        kernels().set_feet(chain, view, settings, q.data(), static_cast<std::int64_t>(rows), met.data(), far.data());
    }
    return nb::make_tuple(q.give(), met.give(), far.give());
}

using In4 = nb::ndarray<const double, nb::ndim<4>, nb::c_contig, nb::device::cpu>;
using In5 = nb::ndarray<const double, nb::ndim<5>, nb::c_contig, nb::device::cpu>;

nb::object promised(const In3& values, const In5& tensor, const In1& tau, const In4& mixed, int rounds, int effort, double exact,
                    int threads) {
    const std::size_t rows = values.shape(0), pieces = values.shape(1), k = values.shape(2), n = tensor.shape(4);
    const auto blocks = [&](const auto& array) {
        return array.shape(0) == rows && array.shape(1) == pieces && array.shape(2) == k && array.shape(3) == k;
    };
    if (!blocks(tensor) || !blocks(mixed) || tau.shape(0) != rows || pieces * k == 0 || n == 0)
        throw nb::value_error("sizes of values, tensor, tau and mixed do not agree");
    if (pieces > 4096 || k > 64 || n > 4096) throw nb::value_error("at most 4096 blocks of 64 values of 4096 joints");
    Result<double> step({rows, n}), fall({rows}), most({rows}), mixture({rows, pieces, k, k});
    const MixtureInput in{static_cast<int>(pieces), static_cast<int>(k), static_cast<int>(n), values.data(), tensor.data(),
                          tau.data(), mixed.data(), rounds, effort, exact};
    const MixtureOutput out{step.data(), fall.data(), most.data(), mixture.data()};
    each(rows, threads, [&](std::int64_t from, std::int64_t to) { mix(in, from, to, out); });
    return nb::make_tuple(step.give(), fall.give(), most.give(), mixture.give());
}

}  // namespace

void bind_search(nb::module_& module) {
    nb::class_<SearchSettings>(module, "SearchSettings")
        .def(nb::new_(&make_search_settings), nb::kw_only(), nb::arg("method"), nb::arg("rank"), nb::arg("iterations"),
             nb::arg("singular"), nb::arg("target"), nb::arg("stationary"), nb::arg("seed"), nb::arg("scale"),
             nb::arg("limits").none(), nb::arg("tie"), nb::arg("share") = 0.0, nb::arg("kicks") = 2);
    nb::class_<NearestSettings>(module, "NearestSettings")
        .def(nb::new_(&make_nearest_settings), nb::kw_only(), nb::arg("rank"), nb::arg("evaluations"), nb::arg("singular"),
             nb::arg("target"), nb::arg("centre"), nb::arg("scale"), nb::arg("limits").none(), nb::arg("still") = 1e-9,
             nb::arg("polish") = true);
    module.def("search", &search, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("settings"), nb::kw_only(),
               nb::arg("first") = 0, nb::arg("history") = false, nb::arg("threads") = 0);
    module.def("nearest", &nearest, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("settings"),
               nb::kw_only(), nb::arg("threads") = 0);
    module.def("set_feet", &set_feet, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::kw_only(),
               nb::arg("centre"), nb::arg("scale"), nb::arg("turn"), nb::arg("farthest"));
    module.def("promised", &promised, nb::arg("values"), nb::arg("tensor"), nb::arg("tau"), nb::arg("mixed"), nb::kw_only(),
               nb::arg("rounds"), nb::arg("effort"), nb::arg("exact"), nb::arg("threads") = 0);
}

}  // namespace rankdrop
