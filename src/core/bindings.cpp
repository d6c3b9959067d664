// Python's view of the core: arrays in, arrays out, the interpreter's lock released. No logic.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "ball.hpp"
#include "kernels.hpp"
#include "parallel.hpp"
#include "readable.hpp"

namespace nb = nanobind;
using namespace rankdrop;

using In1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using In2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

namespace {

constexpr std::int64_t kChunk = 256;

template <class T>
nb::object array(T* data, std::initializer_list<std::size_t> shape) {
    nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.begin(), owner));
}

template <class T>
T* make(std::size_t count) {
    return new T[count > 0 ? count : 1];
}

// rows in chunks over threads, without the interpreter's lock; small batches stay on the calling thread
template <class Work>
void each(std::int64_t rows, int threads, Work work) {
    nb::gil_scoped_release release;
    if (threads == 1 || rows <= kChunk) {
        work(0, rows);
        return;
    }
    volatile bool stop = false;
    parallel_rows(rows, kChunk, threads, &stop, work, [] { return false; });
}

void fit(const Chain& chain, const In2& q) {
    if ((int)q.shape(1) != chain.variables) throw nb::value_error("q has the wrong number of columns");
}

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
                  const In1& scale, const nb::object& limits, double tie, bool history, int threads) {
    fit(chain, starts);
    SearchSettings settings =
        make_settings(chain, view, rank, iterations, singular, target, stationary, seed, scale, limits, tie);
    settings.rotate = method == 2;
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

nb::object links(const Chain& chain, const In2& q, int threads) {
    fit(chain, q);
    const std::size_t rows = q.shape(0), count = chain.joints.size() + 2;
    double* out = make<double>(rows * count * 16);
    each((std::int64_t)rows, threads, [&](std::int64_t a, std::int64_t b) { kernels().links(chain, q.data(), a, b, out); });
    return array(out, {rows, count, 4, 4});
}

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

std::vector<std::string> instruction_sets() {
    const char* names[3];
    const int count = available(names, 3);
    return std::vector<std::string>(names, names + count);
}

}  // namespace

NB_MODULE(_core, module) {
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
    module.def("search", &search, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("rank"), nb::arg("method"),
               nb::arg("iterations"), nb::arg("singular"), nb::arg("target"), nb::arg("stationary"), nb::arg("seed"),
               nb::arg("first"), nb::arg("scale"), nb::arg("limits").none(), nb::arg("tie"), nb::arg("history"),
               nb::arg("threads"));
    module.def("enclose", &enclose, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("half").none(), nb::arg("rank"),
               nb::arg("length"), nb::arg("scale"), nb::arg("arm"), nb::arg("radius"), nb::arg("repeats"),
               nb::arg("threads") = 0);
    module.def("ball", &ball, nb::arg("chain"), nb::arg("view"), nb::arg("q"), nb::arg("matters"), nb::arg("rank"),
               nb::arg("length"), nb::arg("scale"), nb::arg("arm"), nb::arg("radius"), nb::arg("inner"), nb::arg("repeats"),
               nb::arg("smallest"), nb::arg("budget"), nb::arg("keep"));
    module.def("nearest", &nearest, nb::arg("chain"), nb::arg("view"), nb::arg("starts"), nb::arg("centre"),
               nb::arg("rank"), nb::arg("evaluations"), nb::arg("singular"), nb::arg("target"),
               nb::arg("scale"), nb::arg("limits").none(), nb::arg("threads"));
    nb::class_<Families>(module, "Families").def_ro("variables", &Families::variables);
    module.def("links", &links, nb::arg("chain"), nb::arg("q"), nb::arg("threads") = 0);
    module.def("readable", &readable_bases, nb::arg("bases"));
    module.def("make_families", &make_families, nb::arg("variables"), nb::arg("m"), nb::arg("shift"), nb::arg("a"),
               nb::arg("b"), nb::arg("powers"), nb::arg("terms"), nb::arg("equations"), nb::arg("corank"), nb::arg("scale"));
    module.def("monitor", &monitor, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"), nb::arg("generic"),
               nb::arg("singular"), nb::arg("on"), nb::arg("loose"), nb::arg("threads") = 0);
    module.def("monitor_one", &monitor_one, nb::arg("chain"), nb::arg("view"), nb::arg("families"), nb::arg("q"),
               nb::arg("generic"), nb::arg("singular"), nb::arg("on"), nb::arg("loose"));
    module.def("instruction_sets", &instruction_sets);
    module.def("instruction_set", [] { return std::string(kernels().name); });
    module.def("choose_instruction_set", [](const std::string& name) { return choose(name.c_str()); }, nb::arg("name"));
}
