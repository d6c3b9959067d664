// The test that ends an enclosure: no matrix within the bounds of Sigma loses rank.
#pragma once

#include <cmath>
#include <cstring>

#include "lanes.hpp"

namespace rankdrop {

// Is the comparison matrix (sigma_a - B_aa on the diagonal, -B_ab beside it) of size r <= 6 an M-matrix? Solve it for a positive vector y, then look at (C y) itself.
inline bool regular(const double* sigma, const double* bound, int r) {
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

}  // namespace rankdrop

namespace rankdrop::RANKDROP_ISA {

// The same of W matrices of size r: `low` (r) are bounds from below on the diagonal, `bound` (r, r) from above beside it.
template <int r>
inline Mask regular_each(const Pack* low, const Pack* bound) {
    Pack c[r * r], lu[r * r], y[r];
    const Pack zero = fill(0.0), one = fill(1.0);
    Pack good = one;
    const auto keep = [&](Mask mask) { good = select(mask, good, zero); };
    RANKDROP_UNROLL
    for (int a = 0; a < r; ++a) {
        RANKDROP_UNROLL
        for (int b = 0; b < r; ++b) lu[a * r + b] = c[a * r + b] = a == b ? low[a] : -bound[a * r + b];
        y[a] = one;
    }
    RANKDROP_UNROLL
    for (int p = 0; p < r; ++p) {
        const Mask above = lu[p * r + p] > zero;
        keep(above);
        const Pack inverse = one / select(above, lu[p * r + p], one);
        RANKDROP_UNROLL
        for (int a = p + 1; a < r; ++a) {
            const Pack times = lu[a * r + p] * inverse;
            RANKDROP_UNROLL
            for (int b = p + 1; b < r; ++b) lu[a * r + b] = lu[a * r + b] - times * lu[p * r + b];
            y[a] = y[a] - times * y[p];
        }
        lu[p * r + p] = inverse;
    }
    RANKDROP_UNROLL
    for (int a = r - 1; a >= 0; --a) {
        RANKDROP_UNROLL
        for (int b = a + 1; b < r; ++b) y[a] = y[a] - lu[a * r + b] * y[b];
        y[a] = y[a] * lu[a * r + a];
        keep((y[a] > zero) & (y[a] < fill(1e300)));
    }
    RANKDROP_UNROLL
    for (int a = 0; a < r; ++a) {
        Pack sum = zero, size = zero;
        RANKDROP_UNROLL
        for (int b = 0; b < r; ++b) {
            const Pack part = c[a * r + b] * y[b];
            sum = sum + part, size = size + abs(part);
        }
        keep(sum > size * 1e-14);
    }
    return good > zero;
}

}  // namespace rankdrop::RANKDROP_ISA
