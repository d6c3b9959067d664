// The way from points of the singular set to the point of it that is nearest to a given configuration: steps along the
// set against the gradient of the distance, each brought back by Gauss-Newton on F = U2^T J V2 and shortened until the
// distance falls; the curvature of the set is learned on the way (BFGS in the tangent space).
//
// Where F vanishes to second order on a whole piece of the set (Stanford arm: slide at 0), D vanishes there as well, and
// only a point beside the piece tells its normal. So points of the walk are left as soon as sigma <= target, and go on
// to the last digit at the end only.
#pragma once

#include "tangent.hpp"

namespace rankdrop::RANKDROP_ISA {

// Everything is measured in x = (q - centre) / scale, so that a distance is a norm and small ones keep their digits.
class NearestWalk {
  public:
    NearestWalk(const Chain& chain, const View& view, const NearestSettings& settings, Arena& arena)
        : set_(settings), n_(chain.variables), near_(chain, view, settings, arena) {
        const std::size_t n = static_cast<std::size_t>(n_);
        x_ = arena.take<Pack>(n);
        for (Lane& state : lanes_) {
            for (double** vector : {&state.base, &state.way, &state.direction, &state.moved, &state.change})
                *vector = arena.take<double>(n);
            state.inverse = arena.take<double>(n * n);
        }
    }

    // Runs starts begin … end - 1, each from where it stands; `stop` is polled once per evaluation of a pack.
    void run(const double* starts, std::int64_t begin, std::int64_t end, const NearestOutput& out, const std::atomic<bool>& stop) {
        std::int64_t next = begin;
        for (int j = 0; j < n_; ++j) x_[j] = fill(0.0);
        for (;;) {
            bool alive = false;
            for (int lane = 0; lane < W; ++lane) {
                if (lanes_[lane].start < 0 && next < end) enter(lane, next++, starts);
                alive = alive || lanes_[lane].start >= 0;
            }
            if (!alive || stop.load(std::memory_order_relaxed)) return;
            near_.evaluate(x_);
            for (int lane = 0; lane < W; ++lane)
                if (lanes_[lane].start >= 0) judge(lane, out);
        }
    }

  private:
    struct Lane {
        std::int64_t start = -1;
        int evaluations, corrections, shortened;
        bool has_base, polishing, learned;
        double last_sigma, last_length, last_value;  // of the correction before: sigma, its length, smallest value of D
        double radius;      // longest step
        double length;      // step length, as a multiple of `direction`
        double reach;       // |direction|
        double distance2;   // |base|^2
        double slope2;      // |way|^2
        double *base, *way; // a point of the set, and the projection of (centre - base) on its tangent space
        double* direction;  // to go, in the tangent space: inverse * way
        double* inverse;    // estimate of the inverse Hessian of |x|^2 / 2 along the set (n x n)
        double *moved, *change;
    };

    double scale(int j) const { return set_.scale[j]; }

    void enter(int lane, std::int64_t start, const double* starts) {
        Lane& state = lanes_[lane];
        state.start = start;
        state.evaluations = state.corrections = state.shortened = 0;
        state.has_base = state.polishing = false;
        state.radius = set_.step;
        state.last_sigma = HUGE_VAL;
        state.length = 1.0;
        forget(state, n_, 1.0);
        for (int j = 0; j < n_; ++j) set(x_[j], lane, (starts[start * n_ + j] - set_.centre[j]) / scale(j));
    }

    void judge(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        ++state.evaluations;
        const double sigma = get(near_.sigma(), lane), length = norm(near_.correction, lane);
        if (state.polishing) return polish(lane, sigma, length, out);
        const bool last = state.evaluations >= set_.evaluations;
        if (sigma > set_.target) {
            // quadratic where the set is regular, a factor of four where F vanishes to second order; a point that will
            // not come closer is taken as it is if it is singular
            const bool far = state.has_base && length > 2.0 * state.length * state.reach;
            const bool stuck = state.corrections > 1 && !(sigma < 0.9 * state.last_sigma);
            if (!far && !stuck && !last && state.corrections < kCorrections) return correct(lane, sigma, length);
            if (sigma > set_.singular || far) return last ? begin_polish(lane, out) : shorten(lane, out);
        }
        double distance2 = 0.0, along = 0.0;
        for (int j = 0; j < n_; ++j) {
            const double x = get(x_[j], lane);
            distance2 = distance2 + x * x;
            if (state.has_base) along = along + state.way[j] * (x - state.base[j]);
        }
        const double slope = norm(near_.tangent, lane), slope2 = slope * slope;
        if (state.has_base) {
            // the last digits of the distance are those of the way back to the set; there the gradient decides
            const bool nearer = distance2 <= state.distance2 - 1e-4 * std::fmax(along, 0.0);
            const bool flatter = slope2 < state.slope2 && distance2 <= state.distance2 * (1.0 + kNoise);
            if (!nearer && !flatter) return last ? begin_polish(lane, out) : shorten(lane, out);
        }
        accept(lane, distance2, slope2);
        if (last || slope <= set_.still * std::sqrt(distance2) + 1e-15) return begin_polish(lane, out);
        step(lane);
    }

    double norm(const Pack* x, int lane) const {
        double sum = 0.0;
        for (int j = 0; j < n_; ++j) sum = sum + get(x[j], lane) * get(x[j], lane);
        return std::sqrt(sum);
    }

    void correct(int lane, double sigma, double length) {
        Lane& state = lanes_[lane];
        ++state.corrections;
        state.last_sigma = sigma;
        const double cap = std::fmin(1.0, set_.step / std::fmax(length, 1e-300));
        for (int j = 0; j < n_; ++j) set(x_[j], lane, get(x_[j], lane) + cap * get(near_.correction[j], lane));
    }

    // Takes the point as the new base and chooses the next direction
    void accept(int lane, double distance2, double slope2) {
        Lane& state = lanes_[lane];
        for (int j = 0; j < n_; ++j) {
            state.moved[j] = get(x_[j], lane) - state.base[j];
            state.change[j] = state.way[j];
        }
        if (state.has_base) {
            near_.project(lane, state.moved), near_.project(lane, state.change);
            for (int j = 0; j < n_; ++j) state.change[j] = state.change[j] - get(near_.tangent[j], lane);
            learn(state);
            state.radius = std::fmin(2.0 * state.radius, set_.step);
        }
        for (int j = 0; j < n_; ++j) {
            state.base[j] = get(x_[j], lane);
            state.way[j] = get(near_.tangent[j], lane);
        }
        state.has_base = true;
        state.distance2 = distance2;
        state.slope2 = slope2;
        state.shortened = 0;
        aim(lane);
    }

    static double dot(const double* a, const double* b, int n) {
        double sum = 0.0;
        for (int j = 0; j < n; ++j) sum = sum + a[j] * b[j];
        return sum;
    }

    static void forget(Lane& state, int n, double size) {
        for (int i = 0; i < n * n; ++i) state.inverse[i] = i % (n + 1) == 0 ? size : 0.0;
        state.learned = false;
    }

    // BFGS: the inverse Hessian that explains the last change of the gradient, where that is possible
    void learn(Lane& state) {
        const double *s = state.moved, *y = state.change;
        const double sy = dot(s, y, n_), yy = dot(y, y, n_), ss = dot(s, s, n_);
        if (!(sy > 1e-8 * std::sqrt(ss * yy))) return forget(state, n_, 1.0);
        if (!state.learned) forget(state, n_, std::fmin(sy / yy, kLongest));
        state.learned = true;
        double* hy = state.direction;  // will be made anew
        for (int i = 0; i < n_; ++i) hy[i] = dot(state.inverse + i * n_, y, n_);
        const double share = (1.0 + dot(y, hy, n_) / sy) / sy;
        for (int i = 0; i < n_; ++i)
            for (int j = 0; j < n_; ++j)
                state.inverse[i * n_ + j] += share * s[i] * s[j] - (hy[i] * s[j] + s[i] * hy[j]) / sy;
    }

    // The direction from the base: quasi-Newton if it falls, else straight down
    void aim(int lane) {
        Lane& state = lanes_[lane];
        for (int i = 0; i < n_; ++i) state.direction[i] = dot(state.inverse + i * n_, state.way, n_);
        near_.project(lane, state.direction);
        state.reach = std::sqrt(dot(state.direction, state.direction, n_));
        if (!(dot(state.direction, state.way, n_) > 1e-6 * state.reach * std::sqrt(state.slope2))) {
            forget(state, n_, 1.0);
            for (int j = 0; j < n_; ++j) state.direction[j] = state.way[j];
            state.reach = std::sqrt(state.slope2);
        }
        state.length = 1.0;
    }

    void shorten(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.has_base || ++state.shortened > kShortenings) return begin_polish(lane, out);
        state.length *= 0.25;
        state.radius = state.length * state.reach;
        step(lane);
    }

    void step(int lane) {
        Lane& state = lanes_[lane];
        state.length = std::fmin(state.length, state.radius / std::fmax(state.reach, 1e-300));
        state.corrections = 0;
        for (int j = 0; j < n_; ++j) set(x_[j], lane, state.base[j] + state.length * state.direction[j]);
    }

    void begin_polish(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.has_base || !set_.polish) return leave(lane, out);
        state.polishing = true;
        state.corrections = 0;
        state.last_sigma = state.last_length = state.last_value = HUGE_VAL;
        for (int j = 0; j < n_; ++j) set(x_[j], lane, state.base[j]);
    }

    // Gauss-Newton to the last digit. At a double zero steps halve, and F drowns in rounding long before D does: where the
    // last step halved the values of D they are carried on to zero along it.
    void polish(int lane, double sigma, double length, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (sigma > 10.0 * state.last_sigma && sigma > 1e-16) return leave(lane, out);
        double distance2 = 0.0;
        for (int j = 0; j < n_; ++j) {
            state.base[j] = get(x_[j], lane);
            distance2 = distance2 + state.base[j] * state.base[j];
        }
        state.distance2 = distance2;
        const double value = get(near_.smallest, lane);
        const double blurred = 2e-16 / std::fmax(value, 1e-300);
        if (length <= std::fmax(1e-16, blurred) || state.corrections >= kPolish) return leave(lane, out);
        const auto halved = [](double now, double before) { return now > 0.45 * before && now < 0.55 * before; };
        if (halved(value, state.last_value) && halved(length, state.last_length)) {
            for (int j = 0; j < n_; ++j)
                set(x_[j], lane, state.base[j] + state.moved[j] * (value / (state.last_value - value)));
            state.corrections = kPolish;  // the last one
            state.last_sigma = sigma;
            return;
        }
        state.last_length = length;
        state.last_value = value;
        for (int j = 0; j < n_; ++j) state.moved[j] = get(near_.correction[j], lane);
        correct(lane, sigma, length);
    }

    void leave(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        const std::int64_t row = state.start;
        for (int j = 0; j < n_; ++j) {
            double q = set_.centre[j] + (state.has_base ? state.base[j] : get(x_[j], lane)) * scale(j);
            if (!set_.lower.empty()) q = std::fmin(std::fmax(q, set_.lower[j]), set_.upper[j]);
            out.q[row * n_ + j] = q;
        }
        const double length = state.has_base ? std::sqrt(state.distance2) : HUGE_VAL;
        out.distance[row] = length;
        out.stationarity[row] = !state.has_base ? HUGE_VAL : length > 0.0 ? std::sqrt(state.slope2) / length : 0.0;
        out.evaluations[row] = state.evaluations;
        state.start = -1;
    }

    static constexpr int kCorrections = 24;   // of one step
    static constexpr int kShortenings = 12;   // by four, in a row
    static constexpr int kPolish = 6;         // corrections at the end
    static constexpr double kNoise = 1e-11;   // of a squared distance, relative
    static constexpr double kLongest = 50.0;  // first estimate of an inverse curvature

    const NearestSettings& set_;
    const int n_;
    Tangent near_;
    Pack* x_;
    Lane lanes_[W];
};

}  // namespace rankdrop::RANKDROP_ISA
