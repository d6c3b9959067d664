// Singular values and vectors by one-sided Jacobi, the method whose small singular values are right to a fraction of
// eps * ||J|| (LAPACK's gesdd: .9, sqrt(eig(J J^T)): 1e8). The matrix is stored by columns, tall: rows >= columns.
#pragma once

#include "lanes.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr int kMaxSweeps = 16;
inline constexpr int kMaxColumns = 200;  // on the narrow side of a matrix: a task has 6, a family an equation for each joint of the longest arm
inline constexpr int kMaxPairs = kMaxColumns / 2;
// When the Jacobi sweeps may stop.
struct Precision {
    double orthogonal;  // cosine of two columns that are left alone
    double settled;     // a sweep that met no larger cosine, and turned by no larger angle, is the last one
    double turned;      // that angle, as the tangent of its half
};
// What rounding leaves. Cosines of 3e-9 are squared by the sweep that meets them, unless equal lengths make it turn by
// more than that.
inline constexpr Precision kExact{3e-16, 3e-9, 3e-9};
// Columns whose lengths are below this part of the longest, squared, are rounding noise of it, a quarter of eps: nothing
// orders them, and they would turn, ever shorter and at last as subnormal numbers, until the sweeps end.
inline constexpr double kNoise = 0x1p-108;
// For the search. Convergence is quadratic, so that cosines end near 1e-10. A singular value is off by the square of that
// and a subspace by the cosine itself, relative to their sizes: F and D keep nine digits, sigma all of them.
inline constexpr Precision kSearch{1e-9, 1e-5, 2.0};

// (x, y) <- (c x - s y, s x + c y), with h = s / (1 + c): lengths drift least in this form
inline void turn_pair(Pack* x, Pack* y, int length, Pack s, Pack h) {
    for (int k = 0; k < length; ++k) {
        const Pack a = x[k], b = y[k];
        x[k] = a - s * (b + h * a);
        y[k] = b + s * (a - h * b);
    }
}

// Every pair of columns once, in rounds of pairs without a common column (the circle method of tournaments), so that the
// processor overlaps their chains of quotients and roots. With an odd number of columns one sits out each round.
struct RoundRobin {
    int columns, rounds, pairs;

    explicit constexpr RoundRobin(int count) : columns(count), rounds(count - 1 + count % 2), pairs(count / 2) {}

    constexpr void pair_up(int round, unsigned char* left, unsigned char* right) const {
        int count = 0;
        for (int seat = 0; seat < (rounds + 1) / 2; ++seat) {
            const int a = (round + seat) % rounds, b = seat == 0 ? rounds : (round - seat + rounds) % rounds;
            if (a >= columns || b >= columns) continue;
            left[count] = (unsigned char)(a < b ? a : b);
            right[count++] = (unsigned char)(a < b ? b : a);
        }
    }
};

// The pairs of a number of columns known to the compiler, so that loops over them unroll.
template <int COLUMNS>
struct Pairs {
    unsigned char left[COLUMNS][COLUMNS / 2 + 1]{}, right[COLUMNS][COLUMNS / 2 + 1]{};

    constexpr Pairs() {
        const RoundRobin schedule(COLUMNS);
        for (int round = 0; round < schedule.rounds; ++round) schedule.pair_up(round, left[round], right[round]);
    }
};

// Tangent of half the angle that makes two columns orthogonal: tan(2 angle) = p / d, p = 2 x.y, d = |y|^2 - |x|^2, the
// smaller angle. To single precision, in which roots and quotients are cheap: any rotation is exact, and one that is off
// by 1e-7 of its angle leaves 1e-7 of the cosine, as good as a sweep of quadratic convergence.
inline Pack half_tangent(Pack d, Pack p) {
    const Pack size_d = abs(d), size_p = abs(p), unit = to_unit(max(size_d, size_p));
    const Rough rd = rough(size_d * unit), rp = rough(size_p * unit), floor = Rough{} + 1e-18f;
    // what is squared stays above the floor, of no account beside 1: subnormal numbers are slow
    const Rough sd = max(rd, floor), sp = max(rp, floor);
    const Rough t = rp / (rd + sqrt(sd * sd + sp * sp));  // |tan(angle)|, at most 1
    const Rough st = max(t, floor);
    return turned(fine(t / (1.0f + sqrt(1.0f + st * st))), d, p);
}

// In: w, `columns` columns of length `rows`. Out: w = U diag(sigma) with sigma descending, basis = the right vectors
// (columns x columns, by columns) so that  w_in = U diag(sigma) basis^T.
// ROWS, COLUMNS > 0 fix the sizes at compile time (the loops unroll); 0 leaves them to run time.
template <int ROWS, int COLUMNS>
inline void one_sided_jacobi(Pack* w, int rows_, int columns_, Precision precision, Pack* sigma, Pack* basis) {
    const int rows = ROWS ? ROWS : rows_, columns = COLUMNS ? COLUMNS : columns_;
    if (basis)
        for (int i = 0; i < columns; ++i)
            for (int j = 0; j < columns; ++j) basis[i * columns + j] = fill(i == j ? 1.0 : 0.0);
    const Pack tolerance = fill(precision.orthogonal * precision.orthogonal);
    const Pack coarse = fill(precision.settled * precision.settled), one = fill(1.0), zero = fill(0.0);
    const Pack angle = fill(precision.turned);
    Pack noise = zero;
    for (int i = 0; i < columns; ++i) {
        Pack sum = zero;
        for (int k = 0; k < rows; ++k) sum = sum + w[i * rows + k] * w[i * rows + k];
        noise = max(noise, sum * fill(kNoise));
    }
    constexpr Pairs<COLUMNS ? COLUMNS : 2> fixed;
    const RoundRobin schedule(columns);
    Mask open = zero == zero;  // lanes that are not settled: one that is turns no more, whatever its neighbours need
    for (int sweep = 0; sweep < kMaxSweeps && any(open); ++sweep) {
        Mask unsettled = zero > zero;
        for (int round = 0; round < schedule.rounds; ++round) {
            // all sums first, then all angles: the chains of one stage overlap
            Pack difference[kMaxPairs], product[kMaxPairs], sine[kMaxPairs], half[kMaxPairs];
            bool turns[kMaxPairs];
            unsigned char drawn[2][kMaxPairs];
            if (!COLUMNS) schedule.pair_up(round, drawn[0], drawn[1]);
            const unsigned char *left = COLUMNS ? fixed.left[round] : drawn[0], *right = COLUMNS ? fixed.right[round] : drawn[1];
            for (int pair = 0; pair < schedule.pairs; ++pair) {
                const Pack *x = w + left[pair] * rows, *y = w + right[pair] * rows;
                Pack xx = zero, yy = zero, xy = zero;
                for (int k = 0; k < rows; ++k) {
                    xx = xx + x[k] * x[k];
                    yy = yy + y[k] * y[k];
                    xy = xy + x[k] * y[k];
                }
                const Mask turn = (xy * xy > tolerance * (xx * yy)) & (min(xx, yy) > noise) & open;
                turns[pair] = any(turn);
                unsettled = unsettled | ((xy * xy > coarse * (xx * yy)) & turn);
                difference[pair] = yy - xx, product[pair] = select(turn, xy + xy, zero);
            }
            for (int pair = 0; pair < schedule.pairs; ++pair) {
                // sine and half tangent: the form of a rotation in which lengths drift least (Rutishauser)
                const Pack h = select(product[pair] == zero, zero, half_tangent(difference[pair], product[pair]));
                half[pair] = h, sine[pair] = (h + h) / (one + h * h);
                unsettled = unsettled | (abs(h) > angle);
            }
            for (int pair = 0; pair < schedule.pairs; ++pair) {
                if (!turns[pair]) continue;
                const int i = left[pair], j = right[pair];
                turn_pair(w + i * rows, w + j * rows, rows, sine[pair], half[pair]);
                if (basis) turn_pair(basis + i * columns, basis + j * columns, columns, sine[pair], half[pair]);
            }
        }
        open = open & unsettled;
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

inline void svd(Pack* w, int rows, int columns, Precision precision, Pack* sigma, Pack* basis) {
    if (columns == 6 && rows == 7) return one_sided_jacobi<7, 6>(w, rows, columns, precision, sigma, basis);
    if (columns == 6 && rows == 6) return one_sided_jacobi<6, 6>(w, rows, columns, precision, sigma, basis);
    if (columns == 1) return one_sided_jacobi<0, 1>(w, rows, columns, precision, sigma, basis);
    if (columns == 2) return one_sided_jacobi<0, 2>(w, rows, columns, precision, sigma, basis);
    if (columns == 3) return one_sided_jacobi<0, 3>(w, rows, columns, precision, sigma, basis);
    if (columns == 4) return one_sided_jacobi<0, 4>(w, rows, columns, precision, sigma, basis);
    return one_sided_jacobi<0, 0>(w, rows, columns, precision, sigma, basis);
}

// Column j of a basis: the coordinate axis that the columns before it cover least, made orthogonal to them (twice).
// ROWS as in `one_sided_jacobi`.
template <int ROWS = 0>
inline void append_orthogonal(Pack* basis, int rows_, int j) {
    const int rows = ROWS ? ROWS : rows_;
    const Pack zero = fill(0.0), one = fill(1.0);
    Pack least = fill(2.0), which = zero;
    for (int k = 0; k < rows; ++k) {
        Pack cover = zero;
        for (int i = 0; i < j; ++i) cover = cover + basis[i * rows + k] * basis[i * rows + k];
        const Mask better = cover < least;
        least = select(better, cover, least);
        which = select(better, fill((double)k), which);
    }
    Pack* x = basis + j * rows;
    for (int k = 0; k < rows; ++k) x[k] = select(which == fill((double)k), one, zero);
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i < j; ++i) {
            const Pack* y = basis + i * rows;
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

template <int ROWS>
inline void complete_basis_of(const Pack* w, const Pack* sigma, int rows_, int keep, Pack* out) {
    const int rows = ROWS ? ROWS : rows_;
    for (int j = 0; j < rows; ++j) {
        const Mask sound = j < keep ? sigma[j] > sigma[0] * fill(1e-14) : fill(0.0) > fill(1.0);
        const bool all_sound = j < keep && !any(sigma[j] <= sigma[0] * fill(1e-14));
        if (!all_sound) append_orthogonal<ROWS>(out, rows, j);
        if (j >= keep) continue;
        const Pack scale = fill(1.0) / select(sound, sigma[j], fill(1.0));
        for (int k = 0; k < rows; ++k)
            out[j * rows + k] = select(sound, w[j * rows + k] * scale, all_sound ? fill(0.0) : out[j * rows + k]);
    }
}

// Orthonormal basis (rows x rows, by columns) whose first `keep` columns are the directions of w's first columns and
// whose rest completes it. A direction whose sigma is rounding noise is replaced by one from the complement; the others
// are orthogonal as they stand.
inline void complete_basis(const Pack* w, const Pack* sigma, int rows, int keep, Pack* out) {
    if (rows == 7) return complete_basis_of<7>(w, sigma, rows, keep, out);
    if (rows == 6) return complete_basis_of<6>(w, sigma, rows, keep, out);
    return complete_basis_of<0>(w, sigma, rows, keep, out);
}

}  // namespace rankdrop::RANKDROP_ISA
