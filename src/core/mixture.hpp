// The step of a descent over creases: the shortest mixture of the gradients of values that tie.
#pragma once

#include <cstdint>

namespace rankdrop {

// B configurations with `pieces` blocks of k values, whose joint motions are of n variables (see local/minimax.py).
struct MixtureInput {
    int pieces, k, n;
    const double* values;  // (B, pieces, k)
    const double* tensor;  // (B, pieces, k, k, n)
    const double* tau;     // (B)
    const double* mixed;   // (B, pieces, k, k) where to begin
    int rounds;            // of the accelerated projection before it begins anew
    int effort;            // how often it may
    double exact;          // difference of two bounds that is rounding
};

struct MixtureOutput {
    double* step;   // (B, n)
    double* fall;   // (B) of the model's largest value
    double* most;   // (B) what no step's fall less |step|^2 / 2 tau can exceed
    double* mixed;  // (B, pieces, k, k)
};

void mix(const MixtureInput&, std::int64_t begin, std::int64_t end, const MixtureOutput&);

}  // namespace rankdrop
