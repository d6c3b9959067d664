// The test that ends an enclosure: no matrix within the bounds of Sigma loses rank.
#pragma once

#include <cmath>
#include <cstring>

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
