// The derivative of the task Jacobian by every joint, in closed form.
//
// With the columns as the view sees them, (v_i ; w_i) = (R^T (v + w x p) ; R^T w), and
//
//     a = 1 where joint k comes before joint i, b = 1 where it moves the reference point, c = 1 where it turns the axes,
//
// the bracket, the velocity of the point and the turning of the axes come to
//
//     dv_i/dq_k = (a - c) w_k x v_i + (b - a) w_i x v_k,     dw_i/dq_k = (a - c) w_k x w_i,
//
// so that three cross products serve both (i, k) and (k, i), two of them where the point is the tip and the axes rest.
#pragma once

#include "chain.hpp"

namespace rankdrop::RANKDROP_ISA {

class Derivative {
  public:
    Derivative(const Chain& chain, const View& view, Arena& arena)
        : chain_(chain), view_(view), n_(chain.variables), joints_(static_cast<int>(chain.joints.size())) {
        const std::size_t n = static_cast<std::size_t>(n_);
        columns_ = arena.take<Pack>(6 * chain.joints.size());
        bool* driven = arena.take<bool>(n);
        for (int j = 0; j < n_; ++j) driven[j] = false;
        shared_ = joints_ != n_;
        for (const JointConstants& joint : chain.joints) {
            shared_ = shared_ || driven[joint.variable];
            driven[joint.variable] = true;
        }
        whole_ = view.m == 6 && !shared_;
        for (int a = 0; a < view.m; ++a) whole_ = whole_ && view.row[a] == a && view.factor[a] == 1.0;
    }

    // d J[a, i] / d q_k at out[(a * n + i) * n + k]
    void at(const Placed& placed, Pack* out) {
        out_ = out;
        for (int i = 0; i < joints_; ++i) see(placed, placed.screws[i], columns_ + 6 * i);
        if (shared_)
            for (int e = 0; e < view_.m * n_ * n_; ++e) out_[e] = fill(0.0);
        for (int k = 0; k < joints_; ++k)
            for (int i = k; i < joints_; ++i) pair(k, i);
    }

  private:
    // joints k and i, k <= i
    void pair(int k, int i) {
        const Pack *first = columns_ + 6 * k, *second = columns_ + 6 * i;
        const int b_k = k < view_.origin, c_k = k < view_.axes, b_i = i < view_.origin, c_i = i < view_.axes;
        Pack p[3]{}, q[3]{}, turn[3], slope[6];
        if (!c_k || b_i) cross(first + 3, second, p);
        if (!b_k || c_i) cross(second + 3, first, q);
        cross(first + 3, second + 3, turn);
        if (k < i) {
            sum(1 - c_k, p, b_k - 1, q, slope);
            times(1 - c_k, turn, slope + 3);
            put(i, k, slope);
        }
        sum(b_i, p, -c_i, q, slope);
        times(c_i, turn, slope + 3);
        put(k, i, slope);
    }

    // x p + y q for factors -1, 0, 1
    static void sum(int x, const Pack* p, int y, const Pack* q, Pack* out) {
        for (int c = 0; c < 3; ++c) {
            if (y == 0)
                out[c] = x == 0 ? fill(0.0) : p[c];
            else if (x == 0)
                out[c] = y > 0 ? q[c] : -q[c];
            else
                out[c] = y > 0 ? p[c] + q[c] : p[c] - q[c];
        }
    }

    static void times(int x, const Pack* p, Pack* out) {
        for (int c = 0; c < 3; ++c) out[c] = x == 0 ? fill(0.0) : p[c];
    }

    // d column i / d q_k
    void put(int i, int k, const Pack* slope) {
        Pack* slot = out_ + chain_.joints[static_cast<std::size_t>(i)].variable * n_ +
                     chain_.joints[static_cast<std::size_t>(k)].variable;
        if (whole_) {  // the same numbers
            for (int a = 0; a < 6; ++a, slot += n_ * n_) *slot = slope[a];
            return;
        }
        for (int a = 0; a < view_.m; ++a, slot += n_ * n_) {
            const Pack value = slope[view_.row[a]] * view_.factor[a];
            *slot = shared_ ? *slot + value : value;
        }
    }

    const Chain& chain_;
    const View& view_;
    const int n_, joints_;
    bool shared_;  // some variable drives several joints, or none
    bool whole_;   // all rows as they are, and every variable drives one joint
    Pack *columns_, *out_ = nullptr;
};

}  // namespace rankdrop::RANKDROP_ISA
