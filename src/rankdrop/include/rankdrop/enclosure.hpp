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

  private:
    void judge_boxes(std::int64_t row, int count, const EnclosureOutput& out) {
        for (int lane = 0; lane < count; ++lane) {
            double sigma[6], bound[36];
            for (int a = 0; a < r_; ++a) {
                sigma[a] = get(ws_.sigma[a], lane);
                for (int j = 0; j < r_; ++j)
                    bound[a * r_ + j] = get(bound_[a * r_ + j] + third_[j] + slack_, lane) * (1.0 + 1e-12);
            }
            out.free[row + lane] = regular(sigma, bound, r_);
            if (out.split) {
                double widest[kMostJoints] = {};
                int best = 0;
                for (int i = 0; i < joints_; ++i) widest[chain_.joints[i].variable] += get(score_[i], lane);
                for (int k = 1; k < n_; ++k)
                    if (widest[k] > widest[best]) best = k;
                out.split[row + lane] = best;
            }
            if (out.bound) {
                std::memcpy(out.bound + (row + lane) * r_ * r_, bound, sizeof(double) * r_ * r_);
                show(row + lane, lane, out);
            }
        }
    }

    void judge_balls(std::int64_t row, int count, const EnclosureOutput& out) {
        for (int lane = 0; lane < count; ++lane) {
            double sigma[6], bound[36];
            for (int a = 0; a < r_; ++a) sigma[a] = get(ws_.sigma[a], lane);
            const auto at = [&](double radius) {
                const double x = radius * set_.repeats;
                for (int a = 0; a < r_; ++a)
                    for (int j = 0; j < r_; ++j) {
                        const int e = a * r_ + j;
                        bound[e] = x * std::sqrt(get(first_[e], lane)) + 0.5 * x * x * std::sqrt(get(second_[e], lane)) +
                                   x * x * x * get(third_[j], lane) + get(slack_, lane);
                        bound[e] *= 1.0 + 1e-12;
                    }
                return regular(sigma, bound, r_);
            };
            double low = 0.0, high = set_.radius;
            if (!at(0.0)) high = 0.0;
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
