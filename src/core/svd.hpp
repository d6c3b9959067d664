// Singular values and vectors by one-sided Jacobi, the method whose small singular values are right to a fraction of
// eps * ||J|| (LAPACK's gesdd: .9, sqrt(eig(J J^T)): 1e8). The matrix is stored by columns, tall: rows >= columns.
#pragma once

#include "lanes.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr int kMaxSweeps = 16;
inline constexpr double kOrthogonal = 3e-16;  // cosine of two columns taken as orthogonal: what rounding leaves

// (x, y) <- (c x - s y, s x + c y), with h = s / (1 + c)
inline void turn_pair(Pack* x, Pack* y, int length, Pack s, Pack h) {
    for (int k = 0; k < length; ++k) {
        const Pack a = x[k], b = y[k];
        x[k] = a - s * (b + h * a);
        y[k] = b + s * (a - h * b);
    }
}

// In: w, `columns` columns of length `rows`. Out: w = U diag(sigma) with sigma descending, basis = the right vectors
// (columns x columns, by columns) so that  w_in = U diag(sigma) basis^T.
// ROWS, COLUMNS > 0 fix the sizes at compile time (the loops unroll); 0 leaves them to run time.
template <int ROWS, int COLUMNS>
inline void one_sided_jacobi(Pack* w, int rows_, int columns_, Pack* sigma, Pack* basis) {
    const int rows = ROWS ? ROWS : rows_, columns = COLUMNS ? COLUMNS : columns_;
    if (basis)
        for (int i = 0; i < columns; ++i)
            for (int j = 0; j < columns; ++j) basis[i * columns + j] = fill(i == j ? 1.0 : 0.0);
    const Pack tolerance = fill(kOrthogonal), one = fill(1.0), zero = fill(0.0);
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        bool rotated = false;
        for (int i = 0; i + 1 < columns; ++i) {
            for (int j = i + 1; j < columns; ++j) {
                Pack* x = w + i * rows;
                Pack* y = w + j * rows;
                Pack xx = zero, yy = zero, xy = zero;
                for (int k = 0; k < rows; ++k) {
                    xx = xx + x[k] * x[k];
                    yy = yy + y[k] * y[k];
                    xy = xy + x[k] * y[k];
                }
                const Mask turn = abs(xy) > tolerance * sqrt(xx * yy);
                if (!any(turn)) continue;
                rotated = true;
                const Pack zeta = (yy - xx) / (fill(2.0) * select(turn, xy, one));
                const Pack size = one / (abs(zeta) + sqrt(one + zeta * zeta));
                const Pack tangent = select(zeta < zero, -size, size);
                // a rotation by its sine and the tangent of its half angle: the lengths drift least that way (Rutishauser)
                const Pack cosine = one / sqrt(one + tangent * tangent);
                const Pack s = select(turn, cosine * tangent, zero);
                const Pack h = s / (one + cosine);
                turn_pair(x, y, rows, s, h);
                if (basis) turn_pair(basis + i * columns, basis + j * columns, columns, s, h);
            }
        }
        if (!rotated) break;
    }
    for (int i = 0; i < columns; ++i) {
        Pack sum = zero;
        for (int k = 0; k < rows; ++k) sum = sum + w[i * rows + k] * w[i * rows + k];
        sigma[i] = sqrt(sum);
    }
    // descending order, lane by lane: exchanges of neighbours
    for (int pass = columns - 1; pass > 0; --pass) {
        bool exchanged = false;
        for (int i = 0; i < pass; ++i) {
            const Mask wrong = sigma[i] < sigma[i + 1];
            if (!any(wrong)) continue;
            exchanged = true;
            const auto exchange = [&](Pack& a, Pack& b) {
                const Pack keep = a;
                a = select(wrong, b, a);
                b = select(wrong, keep, b);
            };
            exchange(sigma[i], sigma[i + 1]);
            for (int k = 0; k < rows; ++k) exchange(w[i * rows + k], w[(i + 1) * rows + k]);
            if (basis)
                for (int k = 0; k < columns; ++k) exchange(basis[i * columns + k], basis[(i + 1) * columns + k]);
        }
        if (!exchanged) break;
    }
}

inline void svd(Pack* w, int rows, int columns, Pack* sigma, Pack* basis) {
    if (columns == 6 && rows == 7) return one_sided_jacobi<7, 6>(w, rows, columns, sigma, basis);
    if (columns == 6 && rows == 6) return one_sided_jacobi<6, 6>(w, rows, columns, sigma, basis);
    return one_sided_jacobi<0, 0>(w, rows, columns, sigma, basis);
}

// Orthonormal basis (rows x rows, by columns) whose first `keep` columns are the directions of w's first columns and
// whose rest completes it. A direction whose sigma is rounding noise is replaced by one from the complement.
inline void complete_basis(const Pack* w, const Pack* sigma, int rows, int keep, Pack* out) {
    const Pack zero = fill(0.0), one = fill(1.0);
    for (int j = 0; j < rows; ++j) {
        Pack* x = out + j * rows;
        // the unit vector least covered by the columns so far
        Pack cover_best = fill(2.0), which = zero;
        for (int k = 0; k < rows; ++k) {
            Pack cover = zero;
            for (int i = 0; i < j; ++i) cover = cover + out[i * rows + k] * out[i * rows + k];
            const Mask better = cover < cover_best;
            cover_best = select(better, cover, cover_best);
            which = select(better, fill((double)k), which);
        }
        for (int k = 0; k < rows; ++k) x[k] = select(which == fill((double)k), one, zero);
        if (j < keep) {
            const Mask sound = sigma[j] > sigma[0] * fill(1e-14);
            const Pack scale = one / select(sound, sigma[j], one);
            for (int k = 0; k < rows; ++k) x[k] = select(sound, w[j * rows + k] * scale, x[k]);
        }
        for (int pass = 0; pass < 2; ++pass) {
            for (int i = 0; i < j; ++i) {
                const Pack* y = out + i * rows;
                Pack overlap = zero;
                for (int k = 0; k < rows; ++k) overlap = overlap + x[k] * y[k];
                for (int k = 0; k < rows; ++k) x[k] = x[k] - overlap * y[k];
            }
            Pack norm = zero;
            for (int k = 0; k < rows; ++k) norm = norm + x[k] * x[k];
            const Pack scale = one / sqrt(norm);
            for (int k = 0; k < rows; ++k) x[k] = x[k] * scale;
        }
    }
}

}  // namespace rankdrop::RANKDROP_ISA
