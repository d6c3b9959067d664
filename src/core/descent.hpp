// Steepest descent of one singular value (Almarkhi & Maciejewski, eq. 11), plain or with their rotation of the
// singular subspaces where singular values tie (eqs 12-14). Kept for comparison and for their Figures 1-3.
// One start at a time; the lanes evaluate the step lengths of the line search side by side.
#pragma once

#include <algorithm>

#include "block.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

class Descent {
  public:
    static std::size_t size(const Chain& chain, int m) {
        return Workspace::size(chain, m) + (std::size_t)chain.variables * (m + 1);
    }

    // `numbers` has room for doubles() doubles
    static std::size_t doubles(const Chain& chain, int m) {
        const std::size_t n = chain.variables;
        return 8 * n + m + (std::size_t)m * m * n + 2 * (std::size_t)m * n + 2 * m * m;
    }

    Descent(const Chain& chain, const View& view, const SearchSettings& settings, Pack* memory, double* numbers)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables),
          s_(view.m < chain.variables ? view.m : chain.variables), ws_(chain, view.m, memory) {
        scratch_ = memory + Workspace::size(chain, view.m);
        lanes_q_ = scratch_ + n_ * view.m;
        double* next = numbers;
        const auto take = [&](std::size_t count) { double* here = next; next += count; return here; };
        q_ = take(n_), direction_ = take(n_), previous_ = take(n_), mixed_ = take(n_), best_mix_ = take(n_), unit_ = take(n_);
        sigma_ = take(view.m), tensor_ = take(view.m * view.m * n_), gradients_ = take(view.m * n_);
        turned_ = take(view.m * n_), rotation_ = take(view.m * view.m), candidate_ = take(view.m * view.m);
    }

    void run(const double* starts, std::int64_t begin, std::int64_t end, const SearchOutput& out, const volatile bool* stop) {
        for (std::int64_t start = begin; start < end && !*stop; ++start) one(starts, start, out);
    }

  private:
    // refinements of the line search: the step is then right to a thousandth
    static constexpr int kRounds = 5;
    // a gradient shorter than this points nowhere: a step of a given share stays finite
    static constexpr double kFlat = 1e-6;

    void one(const double* starts, std::int64_t start, const SearchOutput& out) {
        for (int j = 0; j < n_; ++j) q_[j] = starts[start * n_ + j];
        Outcome outcome = kSlow;
        int iteration = 0;
        for (;; ++iteration) {
            differentiate();
            const double value = sigma_[set_.rank];
            record(start, iteration, out);
            if (value <= set_.singular) outcome = kConverged;
            if (outcome == kConverged || iteration >= set_.iterations) break;
            std::copy(gradients_, gradients_ + n_, direction_);
            const int tied = set_.rotate ? ties() : 1;
            if (tied > 1) combine(tied);
            if (out.turning && iteration > 0)
                out.turning[start * (set_.iterations + 1) + iteration] = angle(previous_, direction_);
            std::copy(direction_, direction_ + n_, previous_);
            double length = 0.0;
            if (set_.share > 0.0) {
                length = set_.share * value / std::max(aim(direction_), kFlat);
            } else if (value - line_search(direction_, kRounds, length) < 1e-12) {
                outcome = kNearMiss;
                break;
            }
            for (int j = 0; j < n_; ++j) {
                q_[j] -= length * unit_[j];
                if (set_.lower) q_[j] = std::min(std::max(q_[j], set_.lower[j]), set_.upper[j]);
            }
        }
        for (int j = 0; j < n_; ++j) out.q[start * n_ + j] = q_[j];
        for (int i = 0; i < s_; ++i) out.sigma[start * s_ + i] = sigma_[i];
        out.outcome[start] = outcome;
        out.iterations[start] = iteration;
    }

    // Singular values at q and the tensor u_a^T dJ/dq_k v_b of the last ones; gradients are its diagonal (AM eq. 7).
    void differentiate() {
        const int rank = set_.rank, tail = s_ - rank, m = view_.m;
        for (int j = 0; j < n_; ++j) lanes_q_[j] = fill(q_[j]);
        decompose(chain_, view_, lanes_q_, s_, ws_);
        for (int i = 0; i < s_; ++i) sigma_[i] = get(ws_.sigma[i], 0);
        for (int b = 0; b < tail; ++b) {
            derivative_times(chain_, view_, ws_.at, ws_.v + (rank + b) * n_, scratch_);
            for (int a = 0; a < tail; ++a)
                for (int k = 0; k < n_; ++k) {
                    double sum = 0.0;
                    for (int c = 0; c < m; ++c) sum += get(ws_.u[(rank + a) * m + c], 0) * get(scratch_[k * m + c], 0);
                    tensor_[(a * tail + b) * n_ + k] = scale(k) * sum;
                }
        }
        for (int a = 0; a < tail; ++a)
            for (int k = 0; k < n_; ++k) gradients_[a * n_ + k] = tensor_[(a * tail + a) * n_ + k];
    }

    void record(std::int64_t start, int iteration, const SearchOutput& out) {
        if (!out.history) return;
        const std::int64_t row = start * (set_.iterations + 1) + iteration;
        for (int i = 0; i < s_; ++i) out.history[row * s_ + i] = sigma_[i];
    }

    // How many singular values from the driven one on are nearly equal.
    int ties() const {
        int count = 1;
        const double driven = sigma_[set_.rank];
        while (set_.rank + count < s_ && driven - sigma_[set_.rank + count] < set_.tie * driven) ++count;
        return count;
    }

    // AM eq. 12 plane by plane until H, the sum of angles between the gradients (eq. 14), is least; then eq. 13.
    void combine(int count) {
        constexpr int kAngles = 72;
        constexpr double kPi = 3.14159265358979323846;
        for (int i = 0; i < count * count; ++i) rotation_[i] = i % (count + 1) == 0 ? 1.0 : 0.0;
        double least = spread(rotation_, count);
        for (int sweep = 0; sweep < (count == 2 ? 1 : 4); ++sweep)
            for (int a = 0; a < count; ++a)
                for (int b = a + 1; b < count; ++b) {
                    int chosen = 0;
                    for (int step = 1; step < kAngles; ++step) {
                        turn(a, b, kPi * step / kAngles, count);
                        const double h = spread(candidate_, count);
                        if (h < least) least = h, chosen = step;
                    }
                    if (chosen == 0) continue;
                    turn(a, b, kPi * chosen / kAngles, count);
                    std::copy(candidate_, candidate_ + count * count, rotation_);
                }
        rotated_gradients(rotation_, count);
        std::copy(turned_, turned_ + n_, direction_);
        for (int other = 1; other < count; ++other) {
            double best = 1e300;
            for (int part = 0; part <= 10; ++part) {
                const double gamma = part / 10.0;
                for (int k = 0; k < n_; ++k) mixed_[k] = gamma * direction_[k] + (1.0 - gamma) * turned_[other * n_ + k];
                double length = 0.0;
                const double reached = line_search(mixed_, 0, length);
                if (reached < best) best = reached, std::copy(mixed_, mixed_ + n_, best_mix_);
            }
            std::copy(best_mix_, best_mix_ + n_, direction_);
        }
    }

    // candidate = rotation with columns a and b turned by phi
    void turn(int a, int b, double phi, int count) {
        const double c = std::cos(phi), s = std::sin(phi);
        std::copy(rotation_, rotation_ + count * count, candidate_);
        for (int i = 0; i < count; ++i) {
            const double x = rotation_[i * count + a], y = rotation_[i * count + b];
            candidate_[i * count + a] = c * x + s * y;
            candidate_[i * count + b] = c * y - s * x;
        }
    }

    void rotated_gradients(const double* r, int count) {
        const int tail = s_ - set_.rank;
        for (int p = 0; p < count; ++p)
            for (int k = 0; k < n_; ++k) {
                double sum = 0.0;
                for (int a = 0; a < count; ++a)
                    for (int b = 0; b < count; ++b)
                        sum += r[a * count + p] * r[b * count + p] * tensor_[(a * tail + b) * n_ + k];
                turned_[p * n_ + k] = sum;
            }
    }

    double spread(const double* r, int count) {
        rotated_gradients(r, count);
        double sum = 0.0;
        for (int a = 0; a < count; ++a)
            for (int b = a + 1; b < count; ++b) sum += angle(turned_ + a * n_, turned_ + b * n_);
        return sum;
    }

    double angle(const double* x, const double* y) const {
        double xx = 0.0, yy = 0.0, xy = 0.0;
        for (int k = 0; k < n_; ++k) xx += x[k] * x[k], yy += y[k] * y[k], xy += x[k] * y[k];
        const double size = std::sqrt(xx * yy);
        return size > 0.0 ? std::acos(std::min(1.0, std::max(-1.0, xy / size))) : 0.0;
    }

    // Leaves the unit step along a gradient in unit_ (in the joints' own units); the gradient's length.
    double aim(const double* gradient) {
        double norm = 0.0;
        for (int k = 0; k < n_; ++k) norm += gradient[k] * gradient[k];
        norm = std::sqrt(norm);
        for (int k = 0; k < n_; ++k) unit_[k] = norm < 1e-300 ? 0.0 : scale(k) * gradient[k] / norm;
        return norm;
    }

    // Least sigma[rank] along -gradient: a logarithmic grid, then `rounds` refinements of the best bracket.
    // Leaves its length in `length`.
    double line_search(const double* gradient, int rounds, double& length) {
        constexpr int kGrid = 16, kRefine = 8;
        length = 0.0;
        if (aim(gradient) < 1e-300) return sigma_[set_.rank];
        double lengths[kGrid], values[kGrid];
        for (int i = 0; i < kGrid; ++i) lengths[i] = 1e-7 * std::exp(i * std::log(1.5e7) / (kGrid - 1));
        values_along(lengths, kGrid, values);
        int at = (int)(std::min_element(values, values + kGrid) - values);
        double best = values[at], low = at > 0 ? lengths[at - 1] : 0.0, high = at + 1 < kGrid ? lengths[at + 1] : lengths[at];
        length = lengths[at];
        for (int round = 0; round < rounds; ++round) {
            const double step = (high - low) / (kRefine + 1);
            for (int i = 0; i < kRefine; ++i) lengths[i] = low + step * (i + 1);
            values_along(lengths, kRefine, values);
            at = (int)(std::min_element(values, values + kRefine) - values);
            if (values[at] < best) best = values[at], length = lengths[at];
            low = lengths[at] - step, high = lengths[at] + step;
        }
        return best;
    }

    void values_along(const double* lengths, int count, double* values) {
        for (int first = 0; first < count; first += W) {
            for (int lane = 0; lane < W; ++lane) {
                const double length = lengths[std::min(first + lane, count - 1)];
                for (int j = 0; j < n_; ++j) {
                    double value = q_[j] - length * unit_[j];
                    if (set_.lower) value = std::min(std::max(value, set_.lower[j]), set_.upper[j]);
                    set(lanes_q_[j], lane, value);
                }
            }
            decompose(chain_, view_, lanes_q_, -1, ws_);
            for (int lane = 0; lane < W && first + lane < count; ++lane) values[first + lane] = get(ws_.sigma[set_.rank], lane);
        }
    }

    double scale(int j) const { return set_.variable_scale ? set_.variable_scale[j] : 1.0; }

    const Chain& chain_;
    const View& view_;
    const SearchSettings& set_;
    const int n_, s_;
    Workspace ws_;
    Pack *scratch_, *lanes_q_;
    double *q_, *direction_, *previous_, *mixed_, *best_mix_, *unit_, *sigma_, *tensor_, *gradients_, *turned_, *rotation_,
        *candidate_;
};

}  // namespace rankdrop::RANKDROP_ISA
