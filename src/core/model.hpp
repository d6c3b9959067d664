// What the kernels are told about the arm: constants only, filled in once by the bindings.
#pragma once

#include <vector>

namespace rankdrop {

// One joint: exp(S q) = (R, t) with R = I + sin(q) W + (1 - cos q) W W, t = q a + (1 - cos q) b - sin(q) c.
struct JointConstants {
    double v[3], w[3];            // screw at q = 0, linear part first
    double a[3], b[3], c[3];      // translation of the exponential: v + WWv, Wv, WWv (prismatic: v, 0, 0)
    bool turns;                   // revolute or helical
    int variable;                 // which entry of q drives it
    double multiplier, offset;    // joint value = multiplier * q[variable] + offset
};

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
