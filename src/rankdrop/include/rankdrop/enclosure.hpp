// Enclosure: how far the Jacobian can change over a box or a ball around a configuration, and whether its rank can fall.
//
// Screws are seen from a link in the middle of the chain, so that column i depends only on the joints between it and
// that link. With U1, V1 the first r singular directions at the centre, r the rank to be kept,
//
//     U1^T J(q + d) V1 = Sigma + E,   |E_ij| <= B_ij = sum_k |g_ijk| d_k + 1/2 sum_kl |H_ijkl| d_k d_l + T_j
//
// g and H from the bracket at the centre, T the third-order remainder: every derivative of column i by turns, up to the
// third, is bounded by M_i = sqrt(1 + (reach_i / l)^2), one by a slide by 1 / l, and two slides leave nothing. Where the
// matrix with |Sigma_ii| - B_ii on the diagonal and -B_ij beside it is an M-matrix, Sigma + E is regular for every such E,
// and the rank is at least r in the whole box.
#pragma once

#include "comparison.hpp"
#include "expansion.hpp"

namespace rankdrop::RANKDROP_ISA {

class Enclosure : private Expansion {
  public:
    Enclosure(const Chain& chain, const View& view, const EnclosureSettings& settings, Arena& arena)
        : Expansion(chain, view, settings, arena) {}

    // Rows begin … end - 1 of q (and of half, where not null: half-widths of a box in scaled variables; else balls).
    void run(const double* q, const double* half, std::int64_t begin, std::int64_t end, const EnclosureOutput& out) {
        for (std::int64_t row = begin; row < end; row += W) {
            const int count = end - row < W ? (int)(end - row) : W;
            load(q + row * n_, n_, count, n_, q_);
            decompose(chain_, view_, q_, r_, ws_);
            see_screws();
            if (half)
                load_half(half + row * n_, count);
            else
                for (int i = 0; i < joints_; ++i) half_[i] = fill(set_.radius);
            arms();
            expand(half != nullptr);
            if (half)
                judge_boxes(row, count, out);
            else
                judge_balls(row, count, out);
        }
    }

    // Boxes begin … end - 1, each cut by balls: how large a ball may be for the box's part in it to be free.
    //
    // x in a ball of radius rho around the centre's offset c has g . (x - c) between -|g| rho - g . c and |g| rho - g . c,
    // and in the box between -sum |g_k| d_k and sum |g_k| d_k: the narrower of the two counts. On the diagonal only the
    // lower end does.
    void run(const double* q, const double* half, std::int64_t begin, std::int64_t end, const Cut& cut) {
        for (std::int64_t row = begin; row < end; row += W) {
            const int count = end - row < W ? (int)(end - row) : W;
            load(q + row * n_, n_, count, n_, q_);
            decompose_fast(chain_, view_, q_, r_, ws_);
            middle();
            see_screws();
            load_half(half + row * n_, count);
            Pack low, high, extra;
            for (int lane = 0; lane < W; ++lane) {
                const std::int64_t at = row + (lane < count ? lane : count - 1);
                set(low, lane, cut.low[at]), set(high, lane, cut.high[at]), set(extra, lane, cut.rounding[at]);
                for (int i = 0; i < joints_; ++i) set(offset_[i], lane, cut.offset[at * n_ + chain_.joints[i].variable]);
            }
            arms();
            expand(true, true);
            for (int e = 0; e < r_ * r_; ++e) {
                first_[e] = sqrt(first_[e]) * set_.repeats;
                bound_[e] = bound_[e] + third_[e % r_] + slack_;
                bound_[e] = bound_[e] + (bound_[e] + linear_[e]) * 1e-12 + (e % (r_ + 1) ? abs(beside_[e]) : fill(0.0));
            }
            Mask whole = free_within(high, extra);
            low = select(whole, high, low);
            Pack open = select(whole, fill(0.0), fill(1.0));
            for (int step = 0; step < kHalvings && any(open > fill(0.0)); ++step) {
                const Pack middle = (low + high) * 0.5;
                const Mask free = free_within(middle, extra);
                low = select(free, middle, low), high = select(free, high, middle);
            }
            for (int lane = 0; lane < count; ++lane) {
                cut.proven[row + lane] = get(low, lane);
                cut.split[row + lane] = widest(lane);
            }
        }
    }

  private:
    static constexpr int kHalvings = 6;

    // U1^T J V1 at the centre as it is, for U1 and V1 of a quick decomposition: any two of unit columns prove as much
    void middle() {
        const int m = view_.m;
        for (int a = 0; a < r_; ++a) {
            Pack square = fill(0.0);
            for (int c = 0; c < m; ++c) square = square + ws_.u[a * m + c] * ws_.u[a * m + c];
            const Pack scale = fill(1.0) / sqrt(max(square, fill(1e-300)));
            for (int c = 0; c < m; ++c) ws_.u[a * m + c] = ws_.u[a * m + c] * scale;
        }
        for (int j = 0; j < r_; ++j) {
            Pack image[6];
            for (int c = 0; c < m; ++c) {
                image[c] = fill(0.0);
                for (int i = 0; i < n_; ++i) image[c] = image[c] + ws_.jacobian[c * n_ + i] * ws_.v[j * n_ + i];
            }
            for (int a = 0; a < r_; ++a) {
                Pack sum = fill(0.0);
                for (int c = 0; c < m; ++c) sum = sum + ws_.u[a * m + c] * image[c];
                beside_[a * r_ + j] = sum;
            }
        }
    }

    Mask free_within(Pack radius, Pack extra) const {
        switch (r_) {
            case 1: return free_within<1>(radius, extra);
            case 2: return free_within<2>(radius, extra);
            case 3: return free_within<3>(radius, extra);
            case 4: return free_within<4>(radius, extra);
            case 5: return free_within<5>(radius, extra);
            default: return free_within<6>(radius, extra);
        }
    }

    template <int r>
    Mask free_within(Pack radius, Pack extra) const {
        const Pack wide = radius * (1.0 + 1e-12) + extra;
        Pack low[r], beside[r * r];
        RANKDROP_UNROLL
        for (int a = 0; a < r; ++a) {
            RANKDROP_UNROLL
            for (int j = 0; j < r; ++j) {
                const int e = a * r + j;
                const Pack reach = first_[e] * wide;
                if (a == j) low[a] = beside_[e] - min(linear_[e], reach + along_[e]) - bound_[e];
                beside[e] = min(linear_[e], reach + abs(along_[e])) + bound_[e];
            }
        }
        return regular_each<r>(low, beside);
    }

    // The variable that contributes most to the bound
    int widest(int lane) const {
        double share[kMostJoints] = {};
        int best = 0;
        for (int i = 0; i < joints_; ++i) share[chain_.joints[i].variable] += get(score_[i], lane);
        for (int k = 1; k < n_; ++k)
            if (share[k] > share[best]) best = k;
        return best;
    }

    void judge_boxes(std::int64_t row, int count, const EnclosureOutput& out) {
        for (int lane = 0; lane < count; ++lane) {
            double sigma[6], bound[36];
            for (int a = 0; a < r_; ++a) {
                sigma[a] = get(ws_.sigma[a], lane);
                for (int j = 0; j < r_; ++j)
                    bound[a * r_ + j] = get(bound_[a * r_ + j] + third_[j] + slack_, lane) * (1.0 + 1e-12);
            }
            out.free[row + lane] = regular(sigma, bound, r_);
            if (out.split) out.split[row + lane] = widest(lane);
            if (out.bound) {
                std::memcpy(out.bound + (row + lane) * r_ * r_, bound, sizeof(double) * r_ * r_);
                show(row + lane, lane, out);
            }
        }
    }

    void judge_balls(std::int64_t row, int count, const EnclosureOutput& out) {
        for (int lane = 0; lane < count; ++lane) {
            double sigma[6], bound[36], slope[36], bend[36], rest[6];
            for (int a = 0; a < r_; ++a) sigma[a] = get(ws_.sigma[a], lane), rest[a] = get(third_[a], lane);
            for (int e = 0; e < r_ * r_; ++e)
                slope[e] = std::sqrt(get(first_[e], lane)), bend[e] = std::sqrt(get(second_[e], lane));
            const double slack = get(slack_, lane);
            const auto at = [&](double radius) {
                const double x = radius * set_.repeats;
                for (int a = 0; a < r_; ++a)
                    for (int j = 0; j < r_; ++j) {
                        const int e = a * r_ + j;
                        bound[e] = x * slope[e] + 0.5 * x * x * bend[e] + x * x * x * rest[j] + slack;
                        bound[e] *= 1.0 + 1e-12;
                    }
                return regular(sigma, bound, r_);
            };
            double low = 0.0, high = set_.radius;
            if (!at(0.0) || (out.above > 0.0 && !at(out.above))) high = 0.0;
            if (high > 0.0 && at(high)) low = high;
            for (int step = 0; step < 40 && low < high * (1.0 - 1e-9); ++step) {
                const double middle = 0.5 * (low + high);
                (at(middle) ? low : high) = middle;
            }
            out.radius[row + lane] = low;
            if (out.bound) {
                at(low);
                std::memcpy(out.bound + (row + lane) * r_ * r_, bound, sizeof(double) * r_ * r_);
                show(row + lane, lane, out);
            }
        }
    }

    // What the bound speaks of, for those who test it: U1 (m x r), V1 (n x r), sigma, M (joints).
    void show(std::int64_t row, int lane, const EnclosureOutput& out) const {
        const int m = view_.m;
        for (int a = 0; a < r_; ++a) {
            out.sigma[row * r_ + a] = get(ws_.sigma[a], lane);
            for (int c = 0; c < m; ++c) out.u[(row * m + c) * r_ + a] = get(ws_.u[a * m + c], lane);
            for (int i = 0; i < n_; ++i) out.v[(row * n_ + i) * r_ + a] = get(ws_.v[a * n_ + i], lane);
        }
        for (int i = 0; i < joints_; ++i) out.arm[row * joints_ + i] = get(arm_[i], lane);
    }
};

}  // namespace rankdrop::RANKDROP_ISA
