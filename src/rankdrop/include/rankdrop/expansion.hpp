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
        image_ = take(2 * (joints_ + 1) * (joints_ + 1)), value_ = take(joints_);
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
        const auto every_joint = [&](auto by_joint) {  // that moves others: the outermost ones move none
            for (int l = joints_ - 2; l >= link_; --l) by_joint(l, joints_ - 1 - l);
            for (int l = 1; l < link_; ++l) by_joint(l, l);
        };
        every_joint([&](int l, int beyond) {
            if (cut)
                six ? derive<true, true, true>(l, beyond, weight) : derive<true, false, true>(l, beyond, weight);
            else if (box)
                six ? derive<true, true>(l, beyond, weight) : derive<true, false>(l, beyond, weight);
            else
                six ? derive<false, true>(l, beyond, weight) : derive<false, false>(l, beyond, weight);
        });
        for (int j = 0; j < r_; ++j)
            third_[j] = remainder(ws_.v + j * n_, box, box ? weight[j] * weight[r_ - 1] : zero);
    }

    // U1^T [S_l, S_i] of the joints i beyond l, then U1^T [S_k, [S_l, S_i]] of them for each k from l to the link.
    template <bool SIX>
    void see_images(int l, int beyond, int inward, int inner) {
        const int r = SIX ? 6 : r_;
        const auto see_image = [&](const Pack* twist, Pack* image) {
            for (int a = 0; a < r; ++a) image[a] = along_row<SIX>(left_ + 6 * a, twist);
        };
        for (int b = 0; b < beyond; ++b) {
            Pack once[6], twice[6];
            bracket6(mover_ + 6 * l, screw_ + 6 * (l - inward * (b + 1)), once);
            see_image(once, image_ + 6 * b);
            for (int c = 0; c < inner; ++c) {
                bracket6(mover_ + 6 * (l + inward * c), once, twice);
                see_image(twice, image_ + 6 * (beyond * (c + 1) + b));
            }
        }
    }

    // What joint l adds to B: first derivatives by it, and second ones by it and k, k from l to the link. Entry (a, j) of
    // U1^T dJ V1 is a sum over the joints beyond l, few of them: brackets are taken of these, not of the columns of V1.
    template <bool BOX, bool SIX, bool CUT = false>
    void derive(int l, int beyond, const Pack* weight) {
        const int r = SIX ? 6 : r_, side = l < link_, inward = side ? 1 : -1, inner = side ? link_ - l : l - link_ + 1;
        see_images<SIX>(l, beyond, inward, inner);
        const Pack offset = side ? -offset_[l] : offset_[l];
        for (int j = 0; j < r; ++j) {
            for (int b = 0; b < beyond; ++b)
                value_[b] = ws_.v[j * n_ + chain_.joints[l - inward * (b + 1)].variable];
            const auto entry = [&](const Pack* image, int a) {
                Pack sum = image[a] * value_[0];
                for (int b = 1; b < beyond; ++b) sum = sum + image[6 * b + a] * value_[b];
                return sum;
            };
            Pack share = fill(0.0);
            RANKDROP_UNROLL
            for (int a = 0; a < r; ++a) {
                const Pack slope = entry(image_, a);
                const int e = a * r + j;
                if constexpr (BOX) {
                    const Pack part = abs(slope) * half_[l];
                    (CUT ? linear_ : bound_)[e] = (CUT ? linear_ : bound_)[e] + part;
                    share = share + part * weight[a];
                }
                if constexpr (!BOX || CUT) first_[e] = first_[e] + slope * slope;
                if constexpr (CUT) along_[e] = along_[e] + slope * offset;
            }
            score_[l] = score_[l] + share * weight[j];
            for (int c = 0; c < inner; ++c) {
                const int k = l + inward * c;
                const Pack width = half_[k] * half_[l] * (k == l ? 0.5 : 1.0);
                const Pack* image = image_ + 6 * beyond * (c + 1);
                share = fill(0.0);
                RANKDROP_UNROLL
                for (int a = 0; a < r; ++a) {
                    const Pack bend = entry(image, a);
                    const int e = a * r + j;
                    if constexpr (BOX) {
                        const Pack part = abs(bend) * width;
                        bound_[e] = bound_[e] + part;
                        share = share + part * weight[a];
                    } else {
                        second_[e] = second_[e] + bend * bend * (k == l ? 1.0 : 2.0);
                    }
                }
                score_[l] = score_[l] + share * weight[j];
                if (k != l) score_[k] = score_[k] + share * weight[j];
            }
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
    Pack *offset_, *linear_, *along_, *beside_, *image_, *value_;
    Pack slack_;
};

}  // namespace rankdrop::RANKDROP_ISA
