// Enclosure: how far the Jacobian can change over a box or a ball around a configuration, and whether its rank can fall.
//
// Screws are seen from a link in the middle of the chain, so that column i depends only on the joints between it and
// that link. With U1, V1 the first r singular directions at the centre, r the rank to be kept,
//
//     U1^T J(q + d) V1 = Sigma + E,   |E_ij| <= B_ij = sum_k |g_ijk| d_k + 1/2 sum_kl |H_ijkl| d_k d_l + T_j
//
// g and H from the bracket at the centre, T the third-order remainder: every derivative of column i by turns, up to the
// third, is bounded by M_i = sqrt(1 + (reach_i / l)^2), one by a slide by 1 / l, and two slides leave nothing. Where the matrix with |Sigma_ii| - B_ii on the diagonal and -B_ij beside it
// is an M-matrix, Sigma + E is regular for every such E, and the rank is at least r in the whole box.
#pragma once

#include "block.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

// Brackets of twists seen in one link: six components, linear part first.
inline void bracket6(const Pack* a, const Pack* b, Pack sign, Pack* out) {
    Pack left[3], right[3];
    cross(a + 3, b, left);
    cross(a, b + 3, right);
    for (int c = 0; c < 3; ++c) out[c] = sign * (left[c] + right[c]);
    cross(a + 3, b + 3, left);
    for (int c = 0; c < 3; ++c) out[3 + c] = sign * left[c];
}

class Enclosure {
  public:
    Enclosure(const Chain& chain, const View& view, const EnclosureSettings& settings, Arena& arena)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables), joints_((int)chain.joints.size()),
          r_(settings.rank), link_(view.axes), inverse_length_(1.0 / settings.length),
          slides_(view.row[0] < 3), turns_(view.row[view.m - 1] > 2), ws_(chain, view.m, arena) {
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        q_ = take(n_), screw_ = take(joints_ * 6), mover_ = take(joints_ * 6), arm_ = take(joints_), half_ = take(joints_);
        left_ = take(36), first_ = take(36), second_ = take(36), third_ = take(6), bound_ = take(36);
        score_ = take(joints_);
    }

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
    static constexpr double kSlack = 1e-12, kFar = 1e-13, kTurned = 1e-15;  // see allow()
    static constexpr double kMixed = 1.1547005383792517;  // 3 max t^2 s over t^2 + s^2 = 1, that is 2 / sqrt(3), and up

    void see_screws() {
        const double factor[6] = {inverse_length_, inverse_length_, inverse_length_, 1, 1, 1};
        for (int i = 0; i < joints_; ++i) {
            see(ws_.at, ws_.at.screws[i], screw_ + 6 * i);
            for (int c = 0; c < 6; ++c) {
                screw_[6 * i + c] = screw_[6 * i + c] * factor[c];
                mover_[6 * i + c] = screw_[6 * i + c] * set_.scale[chain_.joints[i].variable];
            }
        }
        for (int a = 0; a < r_; ++a) {
            for (int c = 0; c < 6; ++c) left_[6 * a + c] = fill(0.0);
            for (int c = 0; c < view_.m; ++c) left_[6 * a + view_.row[c]] = ws_.u[a * view_.m + c];
        }
    }

    void load_half(const double* half, int count) {
        for (int i = 0; i < joints_; ++i)
            for (int lane = 0; lane < W; ++lane)
                set(half_[i], lane, half[(lane < count ? lane : count - 1) * n_ + chain_.joints[i].variable]);
    }

    // M_i times |multiplier|: bound on every derivative of column i by turning joints, in the box. A slide between i and the
    // link lengthens the reach; a helical joint adds its travel, and its pitch as often as it is differentiated (thrice).
    void arms() {
        const double l = inverse_length_;
        const auto along = [&](int from, int to, int step) {
            Pack extra = fill(0.0);
            for (int i = from; i != to; i += step) {
                const JointConstants& joint = chain_.joints[i];
                const double pitch = joint.w[0] * joint.v[0] + joint.w[1] * joint.v[1] + joint.w[2] * joint.v[2];
                const double size = std::fabs(joint.multiplier);
                const Pack travel = abs(value(i)) + half_[i] * (size * set_.scale[joint.variable]);
                if (joint.turns) {
                    const Pack reach = (fill(set_.arm[i] + std::fabs(pitch)) + extra) * l;
                    arm_[i] = sqrt(fill(turns_) + reach * reach * slides_) * size;
                    if (pitch != 0.0) extra = extra + (travel + fill(3.0)) * std::fabs(pitch);
                } else {
                    arm_[i] = fill(l * slides_ * size);
                    extra = extra + travel;
                }
            }
        };
        along(link_, joints_, 1);
        along(link_ - 1, -1, -1);
    }

    Pack value(int i) const {
        const JointConstants& joint = chain_.joints[i];
        return q_[joint.variable] * joint.multiplier + joint.offset;
    }

    // How far joint i goes for one unit of its variable: radians, or lengths of the view.
    double unit(int i) const {
        const JointConstants& joint = chain_.joints[i];
        const double step = std::fabs(joint.multiplier) * set_.scale[joint.variable];
        return joint.turns ? step : step * inverse_length_;
    }

    // What rounding may do to an entry: of U1^T J V1 beside Sigma and of the sums, per unit of M; of the screws before
    // they are brought to the link, per unit of their size in base coordinates; of large joint values.
    void allow() {
        const double l = inverse_length_;
        Pack size = fill(0.0), far = size, turned = size, point = size;
        for (int c = 0; c < 3; ++c) point = point + abs(ws_.at.p[c]);
        for (int i = 0; i < joints_; ++i) {
            const JointConstants& joint = chain_.joints[i];
            size = size + arm_[i];
            for (int c = 0; c < 3; ++c) far = far + abs(ws_.at.screws[i].v[c]);
            if (joint.turns) far = far + point * std::fabs(joint.multiplier);
            turned = turned + abs(value(i)) * (joint.turns ? 1.0 : l);
        }
        slack_ = fill(kSlack) * (fill(2.0) + size) + far * (kFar * l * slides_) + size * turned * kTurned;
    }

    Pack along_row(const Pack* row, const Pack* twist) const {
        Pack sum = fill(0.0);
        for (int c = 0; c < view_.m; ++c) sum = sum + row[view_.row[c]] * twist[view_.row[c]];
        return sum;
    }

    // visit(k, dJ(e_k) x) from the ends of the chain towards the link
    template <class Visit>
    void walk(const Pack* x, Visit visit) const {
        Pack sum[6], twist[6];
        for (int side = 0; side < 2; ++side) {
            const int from = side ? 0 : joints_ - 1, to = side ? link_ : link_ - 1, step = side ? 1 : -1;
            const Pack sign = fill(side ? -1.0 : 1.0);
            for (Pack& c : sum) c = fill(0.0);
            for (int k = from; k != to; k += step) {
                bracket6(mover_ + 6 * k, sum, sign, twist);
                visit(k, twist);
                const Pack value = x[chain_.joints[k].variable];
                for (int c = 0; c < 6; ++c) sum[c] = sum[c] + screw_[6 * k + c] * value;
            }
        }
    }

    // Coefficients of B: in a box the sums themselves (in bound_), in a ball the norms of g, H and the factor of T.
    void expand(bool box) {
        const Pack zero = fill(0.0);
        for (int e = 0; e < 36; ++e) first_[e] = second_[e] = bound_[e] = zero;
        for (int k = 0; k < joints_; ++k) score_[k] = zero;
        Pack weight[6];
        for (int a = 0; a < r_; ++a) weight[a] = fill(1.0) / sqrt(max(ws_.sigma[a], ws_.sigma[0] * fill(1e-6)));
        allow();
        for (int j = 0; j < r_; ++j) {
            const Pack* x = ws_.v + j * n_;
            walk(x, [&](int l, const Pack* twist) {
                Pack share = zero;
                for (int a = 0; a < r_; ++a) {
                    const Pack slope = along_row(left_ + 6 * a, twist);
                    if (box) {
                        const Pack part = abs(slope) * half_[l];
                        bound_[a * r_ + j] = bound_[a * r_ + j] + part;
                        share = share + part * weight[a];
                    } else {
                        first_[a * r_ + j] = first_[a * r_ + j] + slope * slope;
                    }
                }
                score_[l] = score_[l] + share * weight[j];
                curve(l, j, twist, weight, box);
            });
            third_[j] = remainder(x, box, box ? weight[j] * weight[r_ - 1] : zero);
        }
    }

    // second derivatives by joints l and k, k from l to the link: [S_k, [S_l, .]]
    void curve(int l, int j, const Pack* twist, const Pack* weight, bool box) {
        const int side = l < link_;
        const int to = side ? link_ : link_ - 1, step = side ? 1 : -1;
        const Pack sign = fill(side ? -1.0 : 1.0);
        Pack twice[6];
        for (int k = l; k != to; k += step) {
            bracket6(mover_ + 6 * k, twist, sign, twice);
            const double times = k == l ? 0.5 : 1.0;
            Pack share = fill(0.0);
            for (int a = 0; a < r_; ++a) {
                const Pack bend = along_row(left_ + 6 * a, twice);
                if (box) {
                    const Pack part = abs(bend) * half_[k] * half_[l] * times;
                    bound_[a * r_ + j] = bound_[a * r_ + j] + part;
                    share = share + part * weight[a];
                } else {
                    second_[a * r_ + j] = second_[a * r_ + j] + bend * bend * (k == l ? 1.0 : 2.0);
                }
            }
            score_[l] = score_[l] + share * weight[j];
            if (k != l) score_[k] = score_[k] + share * weight[j];
        }
    }

    // T_j = 1/6 sum_i |x_i| (M_i t^3 + 3 m_i t^2 s), t and s the turns and slides between i and the link, m_i the
    // multiplier of a turning joint; in a ball the factor of radius^3, where t^2 s is largest for s^2 = t^2 / 2.
    Pack remainder(const Pack* x, bool box, Pack weight) {
        Pack total = fill(0.0);
        for (int side = 0; side < 2; ++side) {
            const int from = side ? link_ - 1 : link_, to = side ? -1 : joints_, step = side ? -1 : 1;
            Pack turns = fill(0.0), slides = turns;  // in a ball: sums of squares
            for (int i = from; i != to; i += step) {
                const JointConstants& joint = chain_.joints[i];
                const Pack part = abs(x[joint.variable]) * fill(1.0 / 6.0);
                const double lever = joint.turns ? slides_ * std::fabs(joint.multiplier) : 0.0;
                if (box) {
                    const Pack cubic = part * arm_[i], mixed = part * (3.0 * lever), square = turns * turns;
                    total = total + cubic * square * turns + mixed * square * slides;
                    for (int k = from; k != i; k += step)
                        score_[k] = score_[k] + weight * square * half_[k] * unit(k) *
                                                    (chain_.joints[k].turns ? cubic : mixed);
                } else {
                    total = total + part * turns * (arm_[i] * sqrt(turns) + sqrt(slides) * (kMixed * lever));
                }
                const Pack moved = box ? half_[i] * unit(i) : fill(unit(i) * unit(i));
                (joint.turns ? turns : slides) = (joint.turns ? turns : slides) + moved;
            }
        }
        return total;
    }

    // Is the comparison matrix an M-matrix? Solve it for a positive vector y, then look at (C y) itself.
    static bool regular(const double* sigma, const double* bound, int r) {
        double c[36], y[6];
        for (int a = 0; a < r; ++a) {
            if (!(sigma[a] > bound[a * r + a])) return false;
            for (int b = 0; b < r; ++b) c[a * r + b] = (a == b ? sigma[a] : 0.0) - bound[a * r + b];
            y[a] = 1.0;
        }
        double lu[36];
        std::memcpy(lu, c, sizeof(double) * r * r);
        for (int p = 0; p < r; ++p) {
            if (!(lu[p * r + p] > 0.0)) return false;
            for (int a = p + 1; a < r; ++a) {
                const double times = lu[a * r + p] / lu[p * r + p];
                for (int b = p + 1; b < r; ++b) lu[a * r + b] -= times * lu[p * r + b];
                y[a] -= times * y[p];
            }
        }
        for (int a = r - 1; a >= 0; --a) {
            for (int b = a + 1; b < r; ++b) y[a] -= lu[a * r + b] * y[b];
            y[a] /= lu[a * r + a];
            if (!(y[a] > 0.0) || !std::isfinite(y[a])) return false;
        }
        for (int a = 0; a < r; ++a) {
            double sum = 0.0, size = 0.0;
            for (int b = 0; b < r; ++b) sum += c[a * r + b] * y[b], size += std::fabs(c[a * r + b]) * y[b];
            if (!(sum > 1e-14 * size)) return false;
        }
        return true;
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

    const Chain& chain_;
    const View& view_;
    const EnclosureSettings& set_;
    const int n_, joints_, r_, link_;      // joints before the link are 0 … link - 1
    const double inverse_length_;          // of the translation rows
    const double slides_, turns_;          // 1 where the view has translation rows, rotation rows
    Workspace ws_;
    Pack *q_, *screw_, *mover_, *arm_, *half_, *left_, *first_, *second_, *third_, *bound_, *score_;
    Pack slack_;
};

}  // namespace rankdrop::RANKDROP_ISA
