// Coefficients of the bound B of an enclosure (see enclosure.hpp): brackets at the centre to the second order, and the
// remainder of the third.
#pragma once

#include "block.hpp"
#include "enclosing.hpp"

namespace rankdrop::RANKDROP_ISA {

// Brackets of twists seen in one link: six components, linear part first.
inline void bracket6(const Pack* a, const Pack* b, Pack* out) {
    Pack left[3], right[3];
    cross(a + 3, b, left);
    cross(a, b + 3, right);
    for (int c = 0; c < 3; ++c) out[c] = left[c] + right[c];
    cross(a + 3, b + 3, out + 3);
}

class Expansion {
  protected:
    Expansion(const Chain& chain, const View& view, const EnclosureSettings& settings, Arena& arena)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables), joints_((int)chain.joints.size()),
          r_(settings.rank), link_(view.axes), inverse_length_(1.0 / settings.length),
          slides_(view.row[0] < 3), turns_(view.row[view.m - 1] > 2), ws_(chain, view.m, arena) {
        const auto take = [&](int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); };
        q_ = take(n_), screw_ = take(joints_ * 6), mover_ = take(joints_ * 6), arm_ = take(joints_), half_ = take(joints_);
        left_ = take(36), first_ = take(36), second_ = take(36), third_ = take(6), bound_ = take(36);
        score_ = take(joints_);
        offset_ = take(joints_), linear_ = take(36), along_ = take(36), beside_ = take(36);
    }

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

    // SIX: all six rows of the twist, in their order; else those of the view
    template <bool SIX>
    Pack along_row(const Pack* row, const Pack* twist) const {
        if constexpr (SIX) {
            Pack sum = row[0] * twist[0];
            for (int c = 1; c < 6; ++c) sum = sum + row[c] * twist[c];
            return sum;
        } else {
            Pack sum = fill(0.0);
            for (int c = 0; c < view_.m; ++c) sum = sum + row[view_.row[c]] * twist[view_.row[c]];
            return sum;
        }
    }

    // visit(k, dJ(e_k) x) from the ends of the chain towards the link; with the other sign for joints before the link
    template <class Visit>
    void walk(const Pack* x, Visit visit) const {
        Pack sum[6], twist[6];
        for (int side = 0; side < 2; ++side) {
            const int from = side ? 0 : joints_ - 1, to = side ? link_ : link_ - 1, step = side ? 1 : -1;
            for (Pack& c : sum) c = fill(0.0);
            for (int k = from; k != to; k += step) {
                if (k != from) {  // the outermost joint carries none
                    bracket6(mover_ + 6 * k, sum, twist);
                    visit(k, twist);
                }
                const Pack value = x[chain_.joints[k].variable];
                for (int c = 0; c < 6; ++c) sum[c] = sum[c] + screw_[6 * k + c] * value;
            }
        }
    }

    // Coefficients of B: in a box the sums themselves (in bound_), in a ball the norms of g, H and the factor of T. In a box
    // cut by a ball the sums of first order are apart (linear_), with the squared norms of g (first_) and g . offset
    // (along_). Six of six, the common case, has loops of lengths that the compiler knows.
    void expand(bool box, bool cut = false) {
        const Pack zero = fill(0.0);
        for (int e = 0; e < 36; ++e) first_[e] = second_[e] = bound_[e] = linear_[e] = along_[e] = zero;
        for (int k = 0; k < joints_; ++k) score_[k] = zero;
        Pack weight[6];
        for (int a = 0; a < r_; ++a) weight[a] = fill(1.0) / sqrt(max(ws_.sigma[a], ws_.sigma[0] * fill(1e-6)));
        allow();
        const bool six = r_ == 6 && view_.m == 6;
        for (int j = 0; j < r_; ++j) {
            const Pack* x = ws_.v + j * n_;
            if (cut)
                six ? column<true, true, true>(j, x, weight) : column<true, false, true>(j, x, weight);
            else if (box)
                six ? column<true, true>(j, x, weight) : column<true, false>(j, x, weight);
            else
                six ? column<false, true>(j, x, weight) : column<false, false>(j, x, weight);
            third_[j] = remainder(x, box, box ? weight[j] * weight[r_ - 1] : zero);
        }
    }

    // Column j of B: first derivatives by every joint l, and second ones by l and k, k from l to the link: [S_k, [S_l, .]].
    template <bool BOX, bool SIX, bool CUT = false>
    void column(int j, const Pack* x, const Pack* weight) {
        const int r = SIX ? 6 : r_;
        Pack bound[6], first[6], second[6], linear[6], along[6];
        for (int a = 0; a < r; ++a) bound[a] = first[a] = second[a] = linear[a] = along[a] = fill(0.0);
        walk(x, [&](int l, const Pack* twist) {
            const int side = l < link_;
            const Pack offset = side ? -offset_[l] : offset_[l];
            Pack share = fill(0.0);
            for (int a = 0; a < r; ++a) {
                const Pack slope = along_row<SIX>(left_ + 6 * a, twist);
                if constexpr (BOX) {
                    const Pack part = abs(slope) * half_[l];
                    (CUT ? linear : bound)[a] = (CUT ? linear : bound)[a] + part;
                    share = share + part * weight[a];
                }
                if constexpr (!BOX || CUT) first[a] = first[a] + slope * slope;
                if constexpr (CUT) along[a] = along[a] + slope * offset;
            }
            score_[l] = score_[l] + share * weight[j];
            const int to = side ? link_ : link_ - 1, step = side ? 1 : -1;
            Pack twice[6];
            for (int k = l; k != to; k += step) {
                bracket6(mover_ + 6 * k, twist, twice);
                const Pack width = half_[k] * half_[l] * (k == l ? 0.5 : 1.0);
                share = fill(0.0);
                for (int a = 0; a < r; ++a) {
                    const Pack bend = along_row<SIX>(left_ + 6 * a, twice);
                    if constexpr (BOX) {
                        const Pack part = abs(bend) * width;
                        bound[a] = bound[a] + part;
                        share = share + part * weight[a];
                    } else {
                        second[a] = second[a] + bend * bend * (k == l ? 1.0 : 2.0);
                    }
                }
                score_[l] = score_[l] + share * weight[j];
                if (k != l) score_[k] = score_[k] + share * weight[j];
            }
        });
        for (int a = 0; a < r; ++a) {
            bound_[a * r + j] = bound[a], first_[a * r + j] = first[a], second_[a * r + j] = second[a];
            linear_[a * r + j] = linear[a], along_[a * r + j] = along[a];
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

    const Chain& chain_;
    const View& view_;
    const EnclosureSettings& set_;
    const int n_, joints_, r_, link_;      // joints before the link are 0 … link - 1
    const double inverse_length_;          // of the translation rows
    const double slides_, turns_;          // 1 where the view has translation rows, rotation rows
    Workspace ws_;
    Pack *q_, *screw_, *mover_, *arm_, *half_, *left_, *first_, *second_, *third_, *bound_, *score_;
    Pack *offset_, *linear_, *along_, *beside_;
    Pack slack_;
};

}  // namespace rankdrop::RANKDROP_ISA
