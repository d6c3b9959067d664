// The nearest points of a family to a configuration: Newton's steps on  minimise |x|^2 / 2  subject to  f(q) = 0, with
// x = (q - target) / scale, from many starts.
#pragma once

#include "damped.hpp"
#include "equations.hpp"

namespace rankdrop::RANKDROP_ISA {

// A+ is the pseudoinverse of A = df/dx; small singular values are left out.
class FootFinder {
  public:
    FootFinder(const Families& table, const FootSettings& set, Arena& arena)
        : set_(set), n_(table.variables), c_((int)set.columns.size()), equations_(table, arena) {
        const int e = equations_.count(), wide = std::max(e, n_), narrow = std::min(e, n_);
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        w_ = take(wide * narrow), basis_ = take(narrow * narrow), sigma_ = take(wide), right_ = take(narrow * n_);
        kept_ = take(narrow), left_ = take(narrow * e);
        x_ = take(n_), free_ = take(n_), step_ = take(n_), normal_ = take(n_), slope_ = take(n_), lambda_ = take(e);
        bend_ = take(n_ * n_), curved_ = take(n_ * n_), along_ = take(n_ * n_), product_ = take(n_ * n_);
        at_ = take(n_);
    }

    // q (count, n) in and out: steps on the first `leading` equations until they stand still, whole turns taken off, then
    // onto the zero set of all of them. A lane whose walk has ended takes the next one.
    void run(double* q, std::int64_t count) {
        std::int64_t walk[W], next = 0;
        int rounds[W];
        for (int lane = 0; lane < W; ++lane) walk[lane] = -1, rounds[lane] = 0;
        for (int j = 0; j < n_; ++j) at_[j] = fill(set_.target[j]);
        for (;;) {
            bool alive = false;
            for (int lane = 0; lane < W; ++lane) {
                if (walk[lane] < 0 && next < count && set_.iterations > 0) {
                    walk[lane] = next++, rounds[lane] = 0;
                    for (int j = 0; j < n_; ++j) set(at_[j], lane, q[walk[lane] * n_ + j]);
                }
                alive = alive || walk[lane] >= 0;
            }
            if (!alive) break;
            const Pack length = step(at_);
            for (int lane = 0; lane < W; ++lane) {
                if (walk[lane] < 0) continue;
                if (++rounds[lane] < set_.iterations && get(length, lane) > set_.still && !too_far(lane, get(length, lane))) continue;
                for (int j = 0; j < n_; ++j) q[walk[lane] * n_ + j] = get(at_[j], lane);
                walk[lane] = -1;
            }
        }
        for (std::int64_t row = 0; row < count; row += W) {
            const int lanes = count - row < W ? (int)(count - row) : W;
            load(q + row * n_, n_, lanes, n_, at_);
            onto(at_);
            store(at_, n_, lanes, q + row * n_, n_);
        }
    }

  private:
    // Whether a walk will end beyond `farthest`: Newton's short steps get shorter still
    bool too_far(int lane, double length) const {
        if (!(length < kSure)) return false;
        double square = 0.0;
        for (int j = 0; j < c_; ++j) {
            const int at = set_.columns[j];
            const double x = (get(at_[at], lane) - set_.target[at]) / set_.scale[at];
            square += x * x;
        }
        return std::sqrt(square) - kSlack * length > set_.farthest;
    }

    // One of Newton's steps, capped; how long it was before that
    Pack step(Pack* q) {
        newton(q);
        Pack square = fill(0.0);
        for (int j = 0; j < c_; ++j) square = square + step_[j] * step_[j];
        const Pack length = sqrt(square), share = min(fill(1.0), fill(set_.longest) / max(length, fill(1e-300)));
        for (int j = 0; j < c_; ++j) {
            const int at = set_.columns[j];
            q[at] = inside(at, q[at] + step_[j] * share * fill(set_.scale[at]));
        }
        return length;
    }

    void onto(Pack* q) {
        for (int j = 0; j < n_; ++j) q[j] = brought_near(j, q[j]);
        for (int round = 0; round < set_.returns; ++round) {
            equations_.at(q, equations_.count());
            for (int j = 0; j < c_; ++j) free_[j] = fill(1.0);
            split(equations_.count());
            back();
            for (int j = 0; j < c_; ++j) {
                const int at = set_.columns[j];
                q[at] = inside(at, q[at] + normal_[j] * fill(set_.scale[at]));
            }
        }
    }

    Pack inside(int j, Pack value) const {
        return set_.lower.empty() ? value : min(max(value, fill(set_.lower[j])), fill(set_.upper[j]));
    }

    // Whole turns taken off the way from the target, where the limits let them
    Pack brought_near(int j, Pack value) const {
        if (!set_.periodic[j]) return value;
        const Pack turn = fill(6.283185307179586), round = fill(6755399441055744.0);  // 1.5 * 2^52
        const Pack near = value - turn * (((value - fill(set_.target[j])) / turn + round) - round);
        if (set_.lower.empty()) return near;
        return select((near < fill(set_.lower[j])) | (near > fill(set_.upper[j])), value, near);
    }

    // The step from q; joints at a limit that would cross it are held.
    void newton(const Pack* q) {
        equations_.at(q, set_.leading);
        for (int j = 0; j < c_; ++j) free_[j] = fill(1.0);
        step_from(q);
        if (set_.lower.empty()) return;
        for (int pass = 0; pass < c_; ++pass) {
            bool added = false;
            for (int j = 0; j < c_; ++j) {
                const int at = set_.columns[j];
                const Mask held = ((q[at] <= fill(set_.lower[at])) & (step_[j] < fill(0.0))) |
                                  ((q[at] >= fill(set_.upper[at])) & (step_[j] > fill(0.0)));
                const Mask fresh = held & (free_[j] > fill(0.0));
                if (!any(fresh)) continue;
                added = true;
                free_[j] = select(fresh, fill(0.0), free_[j]);
            }
            if (!added) return;
            step_from(q);
        }
    }

    // -A+ f across the solutions, and along them to the nearest point of the quadratic model. With lambda = (A+)^T x the
    // Lagrangian |x|^2 / 2 - lambda . f has the second derivative C = 1 - sum lambda_i d2f_i; directions in which it is not
    // convex are turned round, so that every step goes down: PCP + 1 - P with |pivots| is inverted, P the projector along the solutions.
    void step_from(const Pack* q) {
        const Pack zero = fill(0.0);
        for (int j = 0; j < c_; ++j) {
            const int at = set_.columns[j];
            x_[j] = (q[at] - fill(set_.target[at])) / fill(set_.scale[at]) * free_[j];
        }
        split(set_.leading);
        back();
        for (int e = 0; e < set_.leading; ++e) lambda_[e] = zero;
        for (int i = 0; i < values_; ++i) {
            Pack share = zero;
            for (int j = 0; j < c_; ++j) share = share + x_[j] * right_[i * c_ + j];
            share = share * kept_[i];
            for (int e = 0; e < set_.leading; ++e) lambda_[e] = lambda_[e] + share * left_[i * set_.leading + e];
        }
        for (int k = 0; k < n_ * n_; ++k) bend_[k] = zero;
        equations_.bend(set_.leading, q, lambda_, bend_);
        for (int j = 0; j < c_; ++j)
            for (int k = 0; k < c_; ++k) {
                const int a = set_.columns[j], b = set_.columns[k];
                const Pack second = bend_[std::max(a, b) * n_ + std::min(a, b)] * (set_.scale[a] * set_.scale[b]);
                curved_[j * c_ + k] = fill(j == k ? 1.0 : 0.0) - second * free_[j] * free_[k];
                Pack across = zero;
                for (int i = 0; i < values_; ++i) across = across + right_[i * c_ + j] * right_[i * c_ + k] * seen(i);
                along_[j * c_ + k] = fill(j == k ? 1.0 : 0.0) - across;
            }
        for (int j = 0; j < c_; ++j) {
            Pack pull = x_[j];
            for (int k = 0; k < c_; ++k) {
                pull = pull + curved_[j * c_ + k] * normal_[k];
                Pack sum = zero;
                for (int i = 0; i < c_; ++i) sum = sum + curved_[j * c_ + i] * along_[i * c_ + k];
                product_[j * c_ + k] = sum;
            }
            step_[j] = pull;
        }
        for (int j = 0; j < c_; ++j) {
            Pack sum = zero;
            for (int k = 0; k < c_; ++k) {
                sum = sum + along_[j * c_ + k] * step_[k];
                if (k > j) continue;  // symmetric
                Pack entry = fill(j == k ? 1.0 : 0.0) - along_[j * c_ + k];
                for (int i = 0; i < c_; ++i) entry = entry + along_[j * c_ + i] * product_[i * c_ + k];
                bend_[j * c_ + k] = entry;  // has been used; c_ <= n_
            }
            slope_[j] = sum;
        }
        solve_convex<0>(bend_, set_.flattest, slope_, c_, step_);
        for (int j = 0; j < c_; ++j) {
            Pack tangent = zero;
            for (int k = 0; k < c_; ++k) tangent = tangent + along_[j * c_ + k] * step_[k];
            product_[j] = (normal_[j] - tangent) * free_[j];
        }
        for (int j = 0; j < c_; ++j) step_[j] = product_[j];
    }

    Pack seen(int i) const { return select(kept_[i] > fill(0.0), fill(1.0), fill(0.0)); }

    // A of the first `count` equations: right vectors (values, c), left ones (values, count), and 1 / sigma, 0 where left out
    void split(int count) {
        const bool wide = count <= c_;  // w = A^T, else A: by columns, tall
        const int tall = std::max(count, c_);
        values_ = std::min(count, c_);
        const auto entry = [&](int e, int j) {
            const int at = set_.columns[j];
            return equations_.slopes[e * n_ + at] * fill(set_.scale[at]) * free_[j];
        };
        for (int i = 0; i < values_; ++i)
            for (int k = 0; k < tall; ++k) w_[i * tall + k] = wide ? entry(i, k) : entry(k, i);
        svd(w_, tall, values_, kExact, sigma_, basis_);
        const Pack floor = max(sigma_[0] * fill(set_.cut), fill(1e-12)), zero = fill(0.0);
        for (int i = 0; i < values_; ++i) {
            const Mask kept = sigma_[i] > floor;
            kept_[i] = select(kept, fill(1.0) / select(kept, sigma_[i], fill(1.0)), zero);
            for (int j = 0; j < c_; ++j) right_[i * c_ + j] = wide ? w_[i * tall + j] * kept_[i] : basis_[i * values_ + j];
            for (int e = 0; e < count; ++e) left_[i * count + e] = wide ? basis_[i * values_ + e] : w_[i * tall + e] * kept_[i];
        }
        counted_ = count;
    }

    // normal_ = -A+ f
    void back() {
        for (int j = 0; j < c_; ++j) normal_[j] = fill(0.0);
        for (int i = 0; i < values_; ++i) {
            Pack share = fill(0.0);
            for (int e = 0; e < counted_; ++e) share = share + left_[i * counted_ + e] * equations_.f[e];
            share = share * kept_[i];
            for (int j = 0; j < c_; ++j) normal_[j] = normal_[j] - right_[i * c_ + j] * share;
        }
    }

    const FootSettings& set_;
    const int n_, c_;
    int values_ = 0, counted_ = 0;
    Equations equations_;
    Pack *w_, *basis_, *sigma_, *right_, *kept_, *left_;
    Pack *x_, *free_, *step_, *normal_, *slope_, *lambda_, *bend_, *curved_, *along_, *product_, *at_;
};

}  // namespace rankdrop::RANKDROP_ISA
