// Block Levenberg-Marquardt: drives F = U2^T J V2 to zero with D as its derivative. Half the squared norm of F is half
// the sum of squares of the singular values beyond `rank`, smooth whatever ties lie among them.
#pragma once

#include "block.hpp"
#include "damped.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

class BlockNewton {
  public:
    BlockNewton(const Chain& chain, const View& view, const SearchSettings& settings, Arena& arena)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables),
          s_(view.m < chain.variables ? view.m : chain.variables), ws_(chain, view.m, arena),
          block_(chain, view.m, settings.rank, arena), here_(n_, arena), trial_(n_, arena) {
        const std::size_t n = static_cast<std::size_t>(n_), s = static_cast<std::size_t>(s_);
        factor_ = arena.take<Pack>(n * n);
        for (Pack** vector : {&q_, &tried_, &step_, &minus_g_, &best_q_, &solution_}) *vector = arena.take<Pack>(n);
        sigma_ = arena.take<Pack>(s), best_sigma_ = arena.take<Pack>(s);
    }

    // Runs starts begin … end - 1; `stop` is polled once per pack iteration.
    void run(const double* starts, std::int64_t begin, std::int64_t end, std::int64_t first, const SearchOutput& out,
             const std::atomic<bool>& stop) {
        std::int64_t next = begin;
        for (int lane = 0; lane < W; ++lane) lanes_[lane].start = -1;
        mu_ = fill(0.0);
        for (int j = 0; j < n_; ++j) q_[j] = fill(0.0);
        here_.size2 = here_.trace = fill(0.0);
        for (;;) {
            bool alive = false, fresh = false;
            for (int lane = 0; lane < W; ++lane) {
                if (lanes_[lane].start < 0 && next < end) {
                    enter(lane, next++, starts);
                    fresh = true;
                }
                alive = alive || lanes_[lane].start >= 0;
            }
            if (!alive || stop.load(std::memory_order_relaxed)) return;
            if (!fresh || !all_fresh()) propose();
            for (int lane = 0; lane < W; ++lane)
                if (lanes_[lane].fresh)
                    for (int j = 0; j < n_; ++j) set(tried_[j], lane, get(q_[j], lane));
            evaluate(tried_, trial_);
            accept();
            for (int lane = 0; lane < W; ++lane)
                if (lanes_[lane].start >= 0) judge(lane, first, out);
        }
    }

  private:
    struct Lane {
        std::int64_t start = -1;
        int iterations = 0, kicks = 0, stalled = 0;
        bool fresh = false, accepted = false, has_best = false;
        double past[10];  // |F|^2 of the last accepted points
        int pasts = 0;
    };

    bool all_fresh() const {
        for (const Lane& lane : lanes_)
            if (lane.start >= 0 && !lane.fresh) return false;
        return true;
    }

    void enter(int lane, std::int64_t start, const double* starts) {
        lanes_[lane] = Lane{};
        lanes_[lane].start = start;
        lanes_[lane].fresh = true;
        for (int j = 0; j < n_; ++j) set(q_[j], lane, starts[start * n_ + j]);
        set(mu_, lane, 1e-2);
    }

    // |F|^2, g and N at q; also leaves sigma in ws_
    void evaluate(const Pack* q, Model& model) {
        Pack fresh = fill(0.0);
        for (int lane = 0; lane < W; ++lane)
            if (lanes_[lane].fresh) set(fresh, lane, 1.0);
        const Mask anew = fresh > fill(0.5);
        decompose_fast(chain_, view_, q, set_.rank, ws_, &anew);
        fill_block(chain_, view_, set_.rank, ws_, block_);
        const int entries = (view_.m - set_.rank) * (n_ - set_.rank);
        n_ == 7 ? sums<7>(entries, model) : n_ == 6 ? sums<6>(entries, model) : sums<0>(entries, model);
        if (!set_.lower.empty()) hold_at_limits(q, model);
        model.trace = fill(0.0);
        for (int j = 0; j < n_; ++j) {
            model.trace = model.trace + model.normal[j * n_ + j];
            for (int k = 0; k < j; ++k) model.normal[k * n_ + j] = model.normal[j * n_ + k];
        }
    }

    // |F|^2, g and the lower half of N, from F and D in scaled variables
    template <int N>
    void sums(int entries, Model& model) {
        const int n = N ? N : n_;
        model.size2 = fill(0.0);
        for (int e = 0; e < entries; ++e) {
            model.size2 = model.size2 + block_.f[e] * block_.f[e];
            for (int j = 0; j < n; ++j) block_.d[e * n + j] = block_.d[e * n + j] * scale(j);
        }
        for (int j = 0; j < n; ++j) {
            Pack slope = fill(0.0), row[N ? N : 1];
            if constexpr (N > 0)
                for (int k = 0; k <= j; ++k) row[k] = fill(0.0);
            else
                for (int k = 0; k <= j; ++k) model.normal[j * n + k] = fill(0.0);
            Pack* sum = N ? row : model.normal + j * n;
            for (int e = 0; e < entries; ++e) {
                const Pack* d = block_.d + e * n;
                slope = slope + d[j] * block_.f[e];
                for (int k = 0; k <= j; ++k) sum[k] = sum[k] + d[j] * d[k];
            }
            model.g[j] = slope;
            if constexpr (N > 0)
                for (int k = 0; k <= j; ++k) model.normal[j * n + k] = row[k];
        }
    }

    void hold_at_limits(const Pack* q, Model& model) {
        const Pack zero = fill(0.0);
        for (int j = 0; j < n_; ++j) {
            const Mask held = ((q[j] <= fill(set_.lower[j])) & (model.g[j] > zero)) |
                              ((q[j] >= fill(set_.upper[j])) & (model.g[j] < zero));
            if (!any(held)) continue;
            model.g[j] = select(held, zero, model.g[j]);
            for (int k = 0; k < n_; ++k) {
                Pack& entry = k <= j ? model.normal[j * n_ + k] : model.normal[k * n_ + j];
                entry = select(held, zero, entry);
            }
        }
    }

    double scale(int j) const { return set_.scale[j]; }

    void propose() {
        const Pack size = sqrt(here_.size2);
        for (int j = 0; j < n_; ++j) minus_g_[j] = -here_.g[j];
        solve_damped(here_.normal, mu_ * size + here_.trace * fill(1e-15) + fill(1e-30), minus_g_, n_, factor_, step_);
        const Pack length = sqrt(dot(step_, step_, n_));
        const Pack cap = min(fill(1.0), fill(set_.step) / max(length, fill(1e-300)));
        for (int j = 0; j < n_; ++j) {
            tried_[j] = q_[j] + step_[j] * cap * scale(j);
            if (!set_.lower.empty()) tried_[j] = min(max(tried_[j], fill(set_.lower[j])), fill(set_.upper[j]));
            step_[j] = (tried_[j] - q_[j]) / fill(scale(j));
        }
    }

    // Gain of the trial against the model's prediction decides the damping, and whether the trial is taken.
    void accept() {
        Pack predicted = -dot(here_.g, step_, n_);
        for (int j = 0; j < n_; ++j) predicted = predicted - fill(0.5) * step_[j] * dot(here_.normal + j * n_, step_, n_);
        const Pack gained = fill(0.5) * (here_.size2 - trial_.size2);
        const Pack gain = gained / max(predicted, fill(1e-300));
        Mask better = trial_.size2 < here_.size2;
        Pack mu = select(gain > fill(0.75), mu_ * fill(0.2), select(gain < fill(0.25), mu_ * fill(4.0), mu_));
        mu = select(better, mu, mu * fill(2.0));
        mu_ = min(max(mu, fill(1e-12)), fill(1e8));
        Pack take = select(better, fill(1.0), fill(0.0));
        for (int lane = 0; lane < W; ++lane) {
            Lane& state = lanes_[lane];
            state.accepted = state.fresh || get(better, lane);
            if (state.fresh) {
                set(take, lane, 1.0);
                set(mu_, lane, 1e-2);
            }
        }
        const Mask taken = take > fill(0.5);
        const Pack before = here_.size2;
        for (int j = 0; j < n_; ++j) {
            q_[j] = select(taken, tried_[j], q_[j]);
            here_.g[j] = select(taken, trial_.g[j], here_.g[j]);
        }
        for (int i = 0; i < n_ * n_; ++i) here_.normal[i] = select(taken, trial_.normal[i], here_.normal[i]);
        here_.size2 = select(taken, trial_.size2, here_.size2);
        here_.trace = select(taken, trial_.trace, here_.trace);
        for (int i = 0; i < s_; ++i) sigma_[i] = select(taken, ws_.sigma[i], sigma_[i]);
        // share of F that motion can still reach: |P_range(D) F|^2 / |F|^2 = g^T N^+ g / |F|^2; a step that halved F is
        // far from a minimum and need not ask
        reachable2_ = fill(1.0);
        const Mask slow = taken & (here_.size2 > fill(0.25) * before);
        if (!any(slow)) return;
        solve_damped(here_.normal, here_.trace * fill(1e-13) + fill(1e-30), here_.g, n_, factor_, solution_);
        reachable2_ = select(slow, dot(here_.g, solution_, n_) / max(here_.size2, fill(1e-300)), reachable2_);
    }


    void judge(int lane, std::int64_t first, const SearchOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.fresh) ++state.iterations;
        state.fresh = false;
        if (out.history && state.iterations <= set_.iterations)
            for (int i = 0; i < s_; ++i)
                out.history[(state.start * (set_.iterations + 1) + state.iterations) * s_ + i] = get(sigma_[i], lane);
        const double sigma = get(sigma_[set_.rank], lane);
        if (sigma <= set_.target) return leave(lane, kConverged, out);
        state.stalled = state.accepted ? 0 : state.stalled + 1;
        if (sigma <= set_.singular && state.stalled > 3) return leave(lane, kConverged, out);
        if (state.accepted) {
            const double size2 = get(here_.size2, lane);
            const double reachable = std::sqrt(std::fmax(0.0, get(reachable2_, lane)));
            // in a curved valley the model promises a fall that never comes: what ten steps gained tells
            const bool flat = state.pasts >= 10 && size2 > (1.0 - 1e-3) * state.past[state.pasts % 10];
            state.past[state.pasts++ % 10] = size2;
            if (sigma > set_.singular && (reachable < set_.stationary || flat)) return minimum(lane, first, out);
        } else if (state.stalled > 40 && sigma > set_.singular) {
            return minimum(lane, first, out);
        }
        if (state.iterations >= set_.iterations) leave(lane, sigma <= set_.singular ? kConverged : kSlow, out);
    }

    // A nonzero local minimum: remember the smallest, start again beside it, and give up after `kicks`.
    void minimum(int lane, std::int64_t first, const SearchOutput& out) {
        Lane& state = lanes_[lane];
        if (!state.has_best || get(sigma_[set_.rank], lane) < get(best_sigma_[set_.rank], lane)) {
            state.has_best = true;
            for (int j = 0; j < n_; ++j) set(best_q_[j], lane, get(q_[j], lane));
            for (int i = 0; i < s_; ++i) set(best_sigma_[i], lane, get(sigma_[i], lane));
        }
        if (state.kicks++ >= set_.kicks || state.iterations >= set_.iterations) return leave(lane, kNearMiss, out);
        for (int j = 0; j < n_; ++j) {
            double value = get(q_[j], lane) + scale(j) * noise(set_.seed, first + state.start, state.kicks, j);
            if (!set_.lower.empty()) value = std::fmin(std::fmax(value, set_.lower[j]), set_.upper[j]);
            set(q_[j], lane, value);
        }
        state.fresh = true;
        state.pasts = state.stalled = 0;
    }

    void leave(int lane, Outcome outcome, const SearchOutput& out) {
        Lane& state = lanes_[lane];
        const bool best = outcome != kConverged && state.has_best &&
                          get(best_sigma_[set_.rank], lane) < get(sigma_[set_.rank], lane);
        for (int j = 0; j < n_; ++j) out.q[state.start * n_ + j] = get(best ? best_q_[j] : q_[j], lane);
        for (int i = 0; i < s_; ++i) out.sigma[state.start * s_ + i] = get(best ? best_sigma_[i] : sigma_[i], lane);
        out.outcome[state.start] = outcome;
        out.iterations[state.start] = state.iterations;
        state.start = -1;
    }

    const Chain& chain_;
    const View& view_;
    const SearchSettings& set_;
    const int n_, s_;
    Workspace ws_;
    Block block_;
    Model here_, trial_;
    Pack *factor_, *q_, *tried_, *step_, *minus_g_, *best_q_, *solution_, *sigma_, *best_sigma_;
    Pack mu_, reachable2_;
    Lane lanes_[W];
};

}  // namespace rankdrop::RANKDROP_ISA
