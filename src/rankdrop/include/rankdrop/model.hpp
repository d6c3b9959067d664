// What the kernels are told about the arm: constants only, filled in once by the bindings.
#pragma once

#include <vector>

namespace rankdrop {

// One joint: exp(S q) = (R, t) with R = I + sin(q) W + (1 - cos q) W W, t = q a + (1 - cos q) b - sin(q) c.
struct JointConstants {
    double v[3], w[3];            // screw at q = 0, linear part first
    double a[3], b[3], c[3];      // translation of the exponential: v + WWv, Wv, WWv (prismatic: v, 0, 0)
    bool turns;                   // revolute or helical
    int axis;                     // 0, 1, 2 where w is exactly ± that axis of the base, else −1
    int variable;                 // which entry of q drives it
    double multiplier, offset;    // joint value = multiplier * q[variable] + offset
};

// Constants of the joint with this screw, linear part first, at q = 0.
inline JointConstants joint_constants(const double* screw, bool turns, int variable, double multiplier, double offset) {
    JointConstants joint{};
    for (int c = 0; c < 3; ++c) joint.v[c] = screw[c], joint.w[c] = screw[3 + c], joint.a[c] = screw[c];
    joint.axis = -1;
    joint.turns = turns, joint.variable = variable, joint.multiplier = multiplier, joint.offset = offset;
    if (!turns) return joint;
    const double *w = joint.w, *v = joint.v;
    for (int c = 0; c < 3; ++c)
        if (w[c] * w[c] == 1.0 && w[(c + 1) % 3] == 0.0 && w[(c + 2) % 3] == 0.0) joint.axis = c;
    const double along = w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    const double wv[3] = {w[1] * v[2] - w[2] * v[1], w[2] * v[0] - w[0] * v[2], w[0] * v[1] - w[1] * v[0]};
    for (int c = 0; c < 3; ++c) {
        joint.b[c] = wv[c];
        joint.c[c] = w[c] * along - v[c];
        joint.a[c] = w[c] * along;
    }
    return joint;
}

struct Chain {
    std::vector<JointConstants> joints;
    std::vector<double> frames;   // (joints + 2) poses at q = 0, 12 numbers each (rotation by rows, then translation)
    int variables = 0;

    int links() const { return static_cast<int>(joints.size()) + 2; }  // base, one after each joint, tip
};

// Which rows of the Jacobian, in whose axes, at which point, divided by what.
struct View {
    int links = 0;                // of the chains it is a view of
    int axes = 0, origin = 0;     // links: 0 base … joints + 1 tip
    double point[3] = {0, 0, 0};  // in the frame of link `origin`
    int m = 6;
    int row[6] = {0, 1, 2, 3, 4, 5};
    double factor[6] = {1, 1, 1, 1, 1, 1};
};

}  // namespace rankdrop
