// Where every link stands: what frames of the chain are seen from.
#pragma once

#include "chain.hpp"

namespace rankdrop::RANKDROP_ISA {

// Poses of the base, of the link after each joint (its frame at q = 0 carried along) and of the tip. Each is 12 packs in
// `out`: rotation by rows, then translation.
inline void place_links(const Chain& chain, const Pack* q, Pack* out) {
    const int joints = (int)chain.joints.size();
    Motion g = identity();
    for (int link = 0; link <= joints + 1; ++link) {
        const double* home = chain.frames.data() + 12 * link;
        Pack* pose = out + 12 * link;
        for (int j = 0; j < 3; ++j) {
            const double column[3] = {home[j], home[3 + j], home[6 + j]};
            Pack turned[3];
            rotate(g, column, turned);
            for (int i = 0; i < 3; ++i) pose[3 * i + j] = turned[i];
        }
        rotate(g, home + 9, pose + 9);
        for (int i = 0; i < 3; ++i) pose[9 + i] = pose[9 + i] + g.t[i];
        if (link >= joints) continue;  // the tip moves with the last joint
        const JointConstants& joint = chain.joints[link];
        advance(g, joint, q[joint.variable] * joint.multiplier + joint.offset);
    }
}

}  // namespace rankdrop::RANKDROP_ISA
