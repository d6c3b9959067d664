// The chain: screws at q, the reference point and axes of a view, the task Jacobian, and the bracket.
#pragma once

#include "lanes.hpp"
#include "memory.hpp"
#include "model.hpp"

namespace rankdrop::RANKDROP_ISA {

struct Twist {
    Pack v[3], w[3];
};

inline void cross(const Pack* a, const Pack* b, Pack* out) {
    const Pack x = a[1] * b[2] - a[2] * b[1];
    const Pack y = a[2] * b[0] - a[0] * b[2];
    const Pack z = a[0] * b[1] - a[1] * b[0];
    out[0] = x, out[1] = y, out[2] = z;
}

inline Pack dot3(const Pack* a, const Pack* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The bracket, the only derivative there is: dS_i/dq_k = [S_k, S_i] for k < i, with
// [A, B] = (w_A x v_B + v_A x w_B ; w_A x w_B).
inline Twist bracket(const Twist& a, const Twist& b) {
    Twist out;
    Pack left[3], right[3];
    cross(a.w, b.v, left);
    cross(a.v, b.w, right);
    for (int i = 0; i < 3; ++i) out.v[i] = left[i] + right[i];
    cross(a.w, b.w, out.w);
    return out;
}

struct Motion {
    Pack r[9], t[3];
};

inline Motion identity() {
    Motion out;
    for (int i = 0; i < 9; ++i) out.r[i] = fill(i % 4 == 0 ? 1.0 : 0.0);
    for (int i = 0; i < 3; ++i) out.t[i] = fill(0.0);
    return out;
}

inline void rotate(const Motion& g, const double* x, Pack* out) {
    for (int i = 0; i < 3; ++i) out[i] = g.r[3 * i] * x[0] + g.r[3 * i + 1] * x[1] + g.r[3 * i + 2] * x[2];
}

// g <- g exp(S value)
inline void advance(Motion& g, const JointConstants& joint, Pack value) {
    Pack r[9], t[3];
    Pack s = fill(0.0), d = fill(0.0);  // sin, 1 - cos
    if (joint.turns) {
        Pack c;
        sincos(value, s, c);
        d = fill(1.0) - c;
    }
    for (int i = 0; i < 3; ++i) t[i] = value * joint.a[i] + d * joint.b[i] - s * joint.c[i];
    for (int i = 0; i < 3; ++i) g.t[i] = g.t[i] + (g.r[3 * i] * t[0] + g.r[3 * i + 1] * t[1] + g.r[3 * i + 2] * t[2]);
    if (!joint.turns) return;
    if (joint.axis >= 0) {  // as most joints of most arms: the same numbers without the products by 0 and 1
        const int i = (joint.axis + 1) % 3, j = (joint.axis + 2) % 3;
        const Pack cosine = fill(1.0) - d, sine = s * joint.w[joint.axis];
        for (int row = 0; row < 9; row += 3) {
            const Pack a = g.r[row + i], b = g.r[row + j];
            g.r[row + i] = a * cosine + b * sine;
            g.r[row + j] = b * cosine - a * sine;
        }
        return;
    }
    const double x = joint.w[0], y = joint.w[1], z = joint.w[2];
    const double ww[9] = {x * x - 1, x * y, x * z, x * y, y * y - 1, y * z, x * z, y * z, z * z - 1};
    const double skew[9] = {0, -z, y, z, 0, -x, -y, x, 0};
    for (int i = 0; i < 9; ++i) r[i] = fill(i % 4 == 0 ? 1.0 : 0.0) + s * skew[i] + d * ww[i];
    for (int i = 0; i < 3; ++i) {
        const Pack a = g.r[3 * i], b = g.r[3 * i + 1], c = g.r[3 * i + 2];
        for (int j = 0; j < 3; ++j) g.r[3 * i + j] = a * r[j] + b * r[3 + j] + c * r[6 + j];
    }
}

// A chain at q, seen through a view.
struct Placed {
    Twist* screws;   // (joints) in base coordinates, times the joint's multiplier
    Pack p[3];       // reference point
    Pack axes[9];    // R: its columns are the axes of the view
    bool base_axes;  // R = I: nothing to turn
    Motion end;      // pose of the tip
};

inline Placed placed_in(const Chain& chain, Arena& arena) {
    Placed out;
    out.screws = arena.take<Twist>(chain.joints.size());
    return out;
}

inline void forward(const Chain& chain, const View& view, const Pack* q, Placed& out) {
    const int joints = (int)chain.joints.size();
    Motion g = identity();
    out.base_axes = view.axes == 0;
    for (int link = 0;; ++link) {
        const double* frame = chain.frames.data() + 12 * link;
        if (link == view.origin) {
            double home[3];
            for (int i = 0; i < 3; ++i)
                home[i] = frame[3 * i] * view.point[0] + frame[3 * i + 1] * view.point[1] +
                          frame[3 * i + 2] * view.point[2] + frame[9 + i];
            rotate(g, home, out.p);
            for (int i = 0; i < 3; ++i) out.p[i] = out.p[i] + g.t[i];
        }
        if (link == view.axes) {
            for (int j = 0; j < 3; ++j) {
                const double column[3] = {frame[j], frame[3 + j], frame[6 + j]};
                Pack turned[3];
                rotate(g, column, turned);
                for (int i = 0; i < 3; ++i) out.axes[3 * i + j] = turned[i];
            }
        }
        if (link == joints + 1) break;
        if (link == joints) continue;  // the tip moves with the last joint
        const JointConstants& joint = chain.joints[link];
        Twist& screw = out.screws[link];
        if (joint.axis >= 0)
            for (int i = 0; i < 3; ++i) screw.w[i] = g.r[3 * i + joint.axis] * joint.w[joint.axis];
        else
            rotate(g, joint.w, screw.w);
        rotate(g, joint.v, screw.v);
        Pack moment[3];
        cross(g.t, screw.w, moment);
        for (int i = 0; i < 3; ++i) {
            screw.v[i] = (screw.v[i] + moment[i]) * joint.multiplier;
            screw.w[i] = screw.w[i] * joint.multiplier;
        }
        advance(g, joint, q[joint.variable] * joint.multiplier + joint.offset);
    }
    const double* home = chain.frames.data() + 12 * (joints + 1);
    for (int j = 0; j < 3; ++j) {
        const double column[3] = {home[j], home[3 + j], home[6 + j]};
        Pack turned[3];
        rotate(g, column, turned);
        for (int i = 0; i < 3; ++i) out.end.r[3 * i + j] = turned[i];
    }
    const double last[3] = {home[9], home[10], home[11]};
    rotate(g, last, out.end.t);
    for (int i = 0; i < 3; ++i) out.end.t[i] = out.end.t[i] + g.t[i];
}

// Components of a space twist in the view, before rows are chosen: (R^T (v + w x p) ; R^T w).
inline void see(const Placed& at, const Twist& s, Pack* out) {
    Pack v[3];
    cross(s.w, at.p, v);
    for (int i = 0; i < 3; ++i) v[i] = s.v[i] + v[i];
    if (at.base_axes) {
        for (int i = 0; i < 3; ++i) out[i] = v[i], out[3 + i] = s.w[i];
        return;
    }
    for (int j = 0; j < 3; ++j) {
        out[j] = at.axes[j] * v[0] + at.axes[3 + j] * v[1] + at.axes[6 + j] * v[2];
        out[3 + j] = at.axes[j] * s.w[0] + at.axes[3 + j] * s.w[1] + at.axes[6 + j] * s.w[2];
    }
}

// Task Jacobian, element (a, j) at out[a * row_step + j * column_step].
inline void jacobian(const Chain& chain, const View& view, const Placed& at, Pack* out, int row_step, int column_step) {
    for (int a = 0; a < view.m; ++a)
        for (int j = 0; j < chain.variables; ++j) out[a * row_step + j * column_step] = fill(0.0);
    Pack column[6];
    for (std::size_t i = 0; i < chain.joints.size(); ++i) {
        see(at, at.screws[i], column);
        const int j = chain.joints[i].variable;
        for (int a = 0; a < view.m; ++a) {
            Pack& slot = out[a * row_step + j * column_step];
            slot = slot + column[view.row[a]] * view.factor[a];
        }
    }
}

// How the view itself moves with joint k: velocity of the reference point, and whether the axes turn.
inline void point_velocity(const View& view, const Placed& at, int k, Pack* out) {
    if (k >= view.origin) {  // joint k (from 0) moves links k + 1 and later
        for (int i = 0; i < 3; ++i) out[i] = fill(0.0);
        return;
    }
    cross(at.screws[k].w, at.p, out);
    for (int i = 0; i < 3; ++i) out[i] = at.screws[k].v[i] + out[i];
}

// The derivative by joint k of the seen twist  see(sum_i S_i x_i), given later = sum over i > k and all = sum over
// every i:  R^T applied to [S_k, later] at the reference point, plus w_all x dp_k, minus w_k x (what is seen).
inline void seen_derivative(const View& view, const Placed& at, int k, const Twist& later, const Twist& all, Pack* out) {
    Twist moved = bracket(at.screws[k], later);
    Pack dp[3], extra[3];
    point_velocity(view, at, k, dp);
    cross(all.w, dp, extra);
    for (int i = 0; i < 3; ++i) moved.v[i] = moved.v[i] + extra[i];
    if (k < view.axes) {
        Pack v[3], turn[3];
        cross(all.w, at.p, v);
        for (int i = 0; i < 3; ++i) v[i] = all.v[i] + v[i];
        // `see` adds w x p to the linear part: take that of the turned angular part out beforehand
        Pack turned_w[3], offset[3];
        cross(at.screws[k].w, all.w, turned_w);
        cross(at.screws[k].w, v, turn);
        cross(turned_w, at.p, offset);
        for (int i = 0; i < 3; ++i) {
            moved.v[i] = moved.v[i] - turn[i] + offset[i];
            moved.w[i] = moved.w[i] - turned_w[i];
        }
    }
    see(at, moved, out);
}

}  // namespace rankdrop::RANKDROP_ISA
