// The way from points of the singular set to the point of it that is nearest to a given configuration: steps along the
// set against the gradient of the distance, each brought back by Gauss-Newton on F = U2^T J V2, step lengths from the
// last two points (Barzilai and Borwein), shortened until the distance falls.
//
// Where F vanishes to second order on a whole piece of the set (Stanford arm: slide at 0), D vanishes there as well, and
// only a point beside the piece tells its normal. So points of the walk are left as soon as sigma <= target, and go on
// to the last digit at the end only.
#pragma once

#include "block.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

// Everything is measured in x = (q - centre) / scale, so that a distance is a norm and small ones keep their digits.
class NearestWalk {
  public:
    static std::size_t size(const Chain& chain, int m, int rank) {
        const std::size_t n = chain.variables, entries = (std::size_t)(m - rank) * (n - rank);
        return Workspace::size(chain, m) + n * m + 6 * n + entries * n + n * n + (entries > n ? entries : n);
    }

    // `numbers` has room for doubles() doubles
    static std::size_t doubles(const Chain& chain) { return (std::size_t)W * 2 * chain.variables; }

    NearestWalk(const Chain& chain, const View& view, const NearestSettings& settings, Pack* memory, double* numbers)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables),
          entries_((view.m - settings.rank) * (n_ - settings.rank)),
          values_(entries_ < n_ ? entries_ : n_), ws_(chain, view.m, memory) {
        Pack* next = memory + Workspace::size(chain, view.m);
        const auto take = [&](std::size_t count) { Pack* here = next; next += count; return here; };
        scratch_ = take(n_ * view.m);
        x_ = take(n_), q_ = take(n_), slope_ = take(n_), correction_ = take(n_), tangent_ = take(n_), free_ = take(n_);
        w_ = take(entries_ * n_), basis_ = take(n_ * n_), size_ = take(entries_ > n_ ? entries_ : n_);
        for (int lane = 0; lane < W; ++lane) {
            lanes_[lane].base = numbers + 2 * lane * n_;
            lanes_[lane].way = lanes_[lane].base + n_;
        }
    }

    // Runs starts begin … end - 1, each from where it stands; `stop` is polled once per evaluation of a pack.
    void run(const double* starts, std::int64_t begin, std::int64_t end, const NearestOutput& out, const volatile bool* stop) {
        std::int64_t next = begin;
        for (int j = 0; j < n_; ++j) x_[j] = fill(0.0);
        for (;;) {
            bool alive = false;
            for (int lane = 0; lane < W; ++lane) {
                if (lanes_[lane].start < 0 && next < end) enter(lane, next++, starts);
                alive = alive || lanes_[lane].start >= 0;
            }
            if (!alive || *stop) return;
            evaluate();
            for (int lane = 0; lane < W; ++lane)
                if (lanes_[lane].start >= 0) judge(lane, out);
        }
    }

  private:
    struct Lane {
        std::int64_t start = -1;
        int evaluations, corrections, shortened;
        bool has_base, polishing;
        double last_sigma, last_length;  // of the correction before
        double radius;      // longest step
        double length;      // step length, as a multiple of `way`
        double distance2;   // |base|^2
        double slope2;      // |way|^2
        double *base, *way; // a point of the set, and the projection of (centre - base) on its tangent space
    };

    double scale(int j) const { return set_.variable_scale[j]; }

    void enter(int lane, std::int64_t start, const double* starts) {
        Lane& state = lanes_[lane];
        state.start = start;
        state.evaluations = state.corrections = state.shortened = 0;
        state.has_base = state.polishing = false;
        state.radius = set_.step;
        state.last_sigma = HUGE_VAL;
        state.length = 1.0;
        for (int j = 0; j < n_; ++j) set(x_[j], lane, (starts[start * n_ + j] - set_.centre[j]) / scale(j));
    }

    // At x_: singular values, Gauss-Newton correction -A^+ F, and the part of -x along the set
    void evaluate() {
        for (int j = 0; j < n_; ++j) {
            q_[j] = fill(set_.centre[j]) + x_[j] * fill(scale(j));
            if (!set_.lower) continue;
            q_[j] = min(max(q_[j], fill(set_.lower[j])), fill(set_.upper[j]));
            x_[j] = (q_[j] - fill(set_.centre[j])) / fill(scale(j));
        }
        decompose(chain_, view_, q_, set_.rank, ws_);
        block(chain_, view_, set_.rank, ws_, scratch_);
        for (int j = 0; j < n_; ++j) free_[j] = fill(1.0);
        for (int e = 0; e < entries_; ++e)
            for (int j = 0; j < n_; ++j) ws_.d[e * n_ + j] = ws_.d[e * n_ + j] * scale(j);
        split();
        if (!set_.lower) return;
        for (int pass = 0; pass < n_ && hold_at_limits(); ++pass) split();
    }

    // Right singular vectors of A = D in scaled variables; those with a value above a cut span what F sees, the rest the
    // tangent space. Joints that are held count as if they were not there. Values that are zero on the set are of the
    // order of sigma beside it, those of a double piece of the order of its root: the cut lies between the two.
    void split() {
        const bool tall = entries_ > n_;
        for (int e = 0; e < entries_; ++e)
            for (int j = 0; j < n_; ++j) w_[tall ? j * entries_ + e : e * n_ + j] = ws_.d[e * n_ + j] * free_[j];
        for (int j = 0; j < n_; ++j) {
            slope_[j] = fill(0.0);
            for (int e = 0; e < entries_; ++e) slope_[j] = slope_[j] + ws_.d[e * n_ + j] * ws_.f[e];
            slope_[j] = slope_[j] * free_[j];
            correction_[j] = fill(0.0);
            tangent_[j] = -x_[j] * free_[j];
        }
        svd(w_, tall ? entries_ : n_, values_, kExact, size_, tall ? basis_ : nullptr);
        const Pack one = fill(1.0), zero = fill(0.0);
        const Pack cut = fill(kCut) * sqrt(max(ws_.sigma[set_.rank], fill(1e-16)));
        smallest_ = size_[0];
        for (int i = 0; i < values_; ++i) {
            const Mask seen = size_[i] > cut;
            if (!any(seen)) break;
            smallest_ = select(seen, size_[i], smallest_);
            const Pack inverse = one / max(size_[i], cut);
            const Pack norm = tall ? one : inverse;
            Pack* v = tall ? basis_ + i * n_ : w_ + i * n_;
            Pack pull = zero, way = zero;
            for (int j = 0; j < n_; ++j) {
                v[j] = v[j] * norm;
                pull = pull + v[j] * slope_[j];
                way = way + v[j] * tangent_[j];
            }
            pull = select(seen, pull * inverse * inverse, zero);
            way = select(seen, way, zero);
            for (int j = 0; j < n_; ++j) {
                correction_[j] = correction_[j] - pull * v[j];
                tangent_[j] = tangent_[j] - way * v[j];
            }
        }
    }

    // Holds joints at a limit that would be pushed across it; true where one was added
    bool hold_at_limits() {
        const Pack zero = fill(0.0);
        const Mask on_set = ws_.sigma[set_.rank] <= fill(set_.target);
        bool added = false;
        for (int j = 0; j < n_; ++j) {
            const Pack push = select(on_set, tangent_[j], correction_[j]);
            const Mask held = ((q_[j] <= fill(set_.lower[j])) & (push < zero)) |
                              ((q_[j] >= fill(set_.upper[j])) & (push > zero));
            if (!any(held)) continue;
            added = true;
            free_[j] = select(held, zero, free_[j]);
        }
        return added;
    }

    void judge(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        ++state.evaluations;
        const double sigma = get(ws_.sigma[set_.rank], lane), length = norm(correction_, lane);
        if (state.polishing) return polish(lane, sigma, length, out);
        const bool last = state.evaluations >= set_.evaluations;
        if (sigma > set_.target) {
            // quadratic where the set is regular, a factor of four where F vanishes to second order; a point that will
            // not come closer is taken as it is if it is singular
            const bool far = state.has_base && length > 2.0 * state.length * std::sqrt(state.slope2);
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
        const double slope = norm(tangent_, lane), slope2 = slope * slope;
        if (state.has_base) {
            // the last digits of the distance are those of the way back to the set; there the gradient decides
            const bool nearer = distance2 <= state.distance2 - 1e-4 * std::fmax(along, 0.0);
            const bool flatter = slope2 < state.slope2 && distance2 <= state.distance2 * (1.0 + kNoise);
            if (!nearer && !flatter) return last ? begin_polish(lane, out) : shorten(lane, out);
        }
        accept(lane, distance2, slope2);
        if (last || slope <= kStill * std::sqrt(distance2) + 1e-15) return begin_polish(lane, out);
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
        for (int j = 0; j < n_; ++j) set(x_[j], lane, get(x_[j], lane) + cap * get(correction_[j], lane));
    }

    // Takes the point as the new base and chooses the next step length from the change of the gradient
    void accept(int lane, double distance2, double slope2) {
        Lane& state = lanes_[lane];
        double moved2 = 0.0, change = 0.0;
        for (int j = 0; j < n_; ++j) {
            const double x = get(x_[j], lane), t = get(tangent_[j], lane);
            if (state.has_base) {
                const double moved = x - state.base[j];
                moved2 = moved2 + moved * moved;
                change = change + moved * (state.way[j] - t);
            }
            state.base[j] = x;
            state.way[j] = t;
        }
        if (state.has_base) {
            const double length = change > 0.0 ? moved2 / change : 4.0 * state.length;
            state.length = std::fmin(std::fmax(length, kShortest), kLongest);
            state.radius = std::fmin(2.0 * state.radius, set_.step);
        }
        state.has_base = true;
        state.distance2 = distance2;
        state.slope2 = slope2;
        state.shortened = 0;
    }

    void shorten(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.has_base || ++state.shortened > kShortenings) return begin_polish(lane, out);
        state.length *= 0.25;
        state.radius = state.length * std::sqrt(state.slope2);
        step(lane);
    }

    void step(int lane) {
        Lane& state = lanes_[lane];
        state.length = std::fmin(state.length, state.radius / std::fmax(std::sqrt(state.slope2), 1e-300));
        state.corrections = 0;
        for (int j = 0; j < n_; ++j) set(x_[j], lane, state.base[j] + state.length * state.way[j]);
    }

    void begin_polish(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.has_base) return leave(lane, out);
        state.polishing = true;
        state.corrections = 0;
        state.last_sigma = state.last_length = HUGE_VAL;
        for (int j = 0; j < n_; ++j) set(x_[j], lane, state.base[j]);
    }

    // Gauss-Newton to the last digit that F holds; twice the step where steps halve, which is what they do at a double zero
    void polish(int lane, double sigma, double length, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        if (sigma > 10.0 * state.last_sigma && sigma > 1e-16) return leave(lane, out);
        double distance2 = 0.0;
        for (int j = 0; j < n_; ++j) {
            state.base[j] = get(x_[j], lane);
            distance2 = distance2 + state.base[j] * state.base[j];
        }
        state.distance2 = distance2;
        const double blurred = 2e-16 / std::fmax(get(smallest_, lane), 1e-300);
        if (length <= std::fmax(1e-16, blurred) || state.corrections >= kPolish) return leave(lane, out);
        const double ratio = length / state.last_length;
        const double factor = ratio > 0.4 && ratio < 0.6 ? 2.0 : 1.0;
        state.last_length = length;
        correct(lane, sigma, length);
        if (factor > 1.0)
            for (int j = 0; j < n_; ++j) set(x_[j], lane, get(x_[j], lane) + get(correction_[j], lane));
    }

    void leave(int lane, const NearestOutput& out) {
        Lane& state = lanes_[lane];
        const std::int64_t row = state.start;
        for (int j = 0; j < n_; ++j) {
            double q = set_.centre[j] + (state.has_base ? state.base[j] : get(x_[j], lane)) * scale(j);
            if (set_.lower) q = std::fmin(std::fmax(q, set_.lower[j]), set_.upper[j]);
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
    static constexpr double kStill = 1e-9;    // |way| / distance at which a point is the nearest
    static constexpr int kPolish = 6;         // corrections at the end
    static constexpr double kCut = 1e-2;      // values of D below this times the root of sigma are zero
    static constexpr double kNoise = 1e-11;   // of a squared distance, relative
    static constexpr double kShortest = 1e-3, kLongest = 50.0;  // step lengths from differences

    const Chain& chain_;
    const View& view_;
    const NearestSettings& set_;
    const int n_, entries_, values_;
    Workspace ws_;
    Pack *scratch_, *x_, *q_, *slope_, *correction_, *tangent_, *free_, *w_, *basis_, *size_;
    Pack smallest_;  // singular value of A that is not zero
    Lane lanes_[W];
};

}  // namespace rankdrop::RANKDROP_ISA
