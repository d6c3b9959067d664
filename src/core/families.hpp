// Families of singular configurations as flat tables of numbers, and what a monitor says of each configuration.
#pragma once

#include <cstdint>
#include <vector>

namespace rankdrop {

// Equations f = sum_t (a_t cos(m_t . q - shift_t) + b_t sin(m_t . q - shift_t)) prod_j q_j^p_tj. Families stand in the
// order in which they are preferred.
struct Families {
    int variables = 0;
    std::vector<double> m;            // (terms, n)
    std::vector<double> shift, a, b;  // (terms)
    std::vector<int> powers;          // (terms, n)
    std::vector<int> terms;           // first term of every equation, and the end
    std::vector<int> equations;       // first equation of every family, and the end
    std::vector<int> corank;          // of every family
    std::vector<double> scale;        // (n) what a joint motion is measured by: 1, or the length scale
    std::vector<int> periodic;        // (n) 1: a turn of 2 pi is no motion
    std::vector<int> coupled;         // of every equation: 0 where pinned joints alone say it
    std::vector<int> pins;            // first pinned joint of every family, and the end
    std::vector<int> pinned;          // the pinned joints
    std::vector<int> at;              // first value of every pinned joint, and the end
    std::vector<double> values;       // [rad, or the unit of the arm's lengths]
};

struct MonitorSettings {
    int generic = 0;         // generic rank
    double singular = 1e-9;  // sigma at or below: zero
    double on = 1e-5;        // a singular configuration with a smaller residual lies on the family [rad]
    double loose = 1e-3;     // where none of its corank does: the nearest one of its corank, up to here [rad]
};

// Rows are configurations; `v` may be null.
struct SightingsOutput {
    double *sigma, *u, *v, *residual, *distance;
    std::int32_t *rank, *family, *nearest;
};

}  // namespace rankdrop
