// The SVD of a single matrix of six columns, by the rotations of svd.hpp with a lane for each pair of columns of a round:
// three rotations at once, on the same numbers in the same order, so that every bit is that of the lanes of svd.hpp.
#pragma once

#include <utility>

#include "svd.hpp"

#if RANKDROP_WIDTH >= 4
namespace rankdrop::RANKDROP_ISA::single_svd {

inline constexpr int kColumns = 6, kPairs = 3;
static_assert(W == 4 || W == 8, "a lane for each of three pairs");
inline constexpr Pairs<kColumns> kSchedule;

// Where a column is in a round: its lane among the left ones, or W + its lane among the right ones.
constexpr int seat_of(int round, int column) {
    for (int pair = 0; pair < kPairs; ++pair) {
        if (kSchedule.left[round][pair] == column) return pair;
        if (kSchedule.right[round][pair] == column) return W + pair;
    }
    return 0;
}

// Rows of a matrix, its columns in pairs: those of one lane are turned together. The other lanes hold zeros.
template <int ROWS>
struct Seated {
    Pack left[ROWS], right[ROWS];

    // From the seats of a round to those of the next
    template <int ROUND>
    void move_on() {
        constexpr int next = (ROUND + 1) % (kColumns - 1);
        constexpr auto from_left = [](int pair) { return seat_of(ROUND, kSchedule.left[next][pair]); };
        constexpr auto from_right = [](int pair) { return seat_of(ROUND, kSchedule.right[next][pair]); };
        for (int k = 0; k < ROWS; ++k) {
            const Pack a = left[k], b = right[k];
#if RANKDROP_WIDTH == 4
            left[k] = RANKDROP_SHUFFLE(a, b, from_left(0), from_left(1), from_left(2), 3);
            right[k] = RANKDROP_SHUFFLE(a, b, from_right(0), from_right(1), from_right(2), 7);
#else
            left[k] = RANKDROP_SHUFFLE(a, b, from_left(0), from_left(1), from_left(2), 3, 4, 5, 6, 7);
            right[k] = RANKDROP_SHUFFLE(a, b, from_right(0), from_right(1), from_right(2), 11, 12, 13, 14, 15);
#endif
        }
    }

    double at(int column, int row) const {
        const int seat = seat_of(0, column);
        return seat < W ? left[row][seat] : right[row][seat - W];
    }
};

struct Sums {
    Pack xx, yy, xy;
};

template <int ROWS>
inline Sums sums_of(const Seated<ROWS>& w) {
    Sums sums{fill(0.0), fill(0.0), fill(0.0)};
    for (int k = 0; k < ROWS; ++k) {
        sums.xx = sums.xx + w.left[k] * w.left[k];
        sums.yy = sums.yy + w.right[k] * w.right[k];
        sums.xy = sums.xy + w.left[k] * w.right[k];
    }
    return sums;
}

template <int ROWS, bool BASIS>
struct Jacobi {
    Seated<ROWS> w;
    Seated<kColumns> basis;
    Pack noise;
    Mask unsettled;

    template <int ROUND>
    void round() {
        const Pack zero = fill(0.0), one = fill(1.0);
        const auto [xx, yy, xy] = sums_of(w);
        const Pack tolerance = fill(kExact.orthogonal * kExact.orthogonal), coarse = fill(kExact.settled * kExact.settled);
        const Mask turn = (xy * xy > tolerance * (xx * yy)) & (min(xx, yy) > noise);
        if (any(turn)) {
            unsettled = unsettled | ((xy * xy > coarse * (xx * yy)) & turn);
            const Pack product = select(turn, xy + xy, zero);
            const Pack h = select(product == zero, zero, half_tangent(yy - xx, product)), s = (h + h) / (one + h * h);
            unsettled = unsettled | (abs(h) > fill(kExact.turned));
            turn_pair(w.left, w.right, ROWS, s, h);
            if constexpr (BASIS) turn_pair(basis.left, basis.right, kColumns, s, h);
        }
        w.template move_on<ROUND>();
        if constexpr (BASIS) basis.template move_on<ROUND>();
    }

    template <int... ROUNDS>
    void sweep(std::integer_sequence<int, ROUNDS...>) {
        (round<ROUNDS>(), ...);
    }

    void run(double* matrix, double* sigma, double* vectors) {
        for (int k = 0; k < ROWS; ++k) seat(matrix, ROWS, k, w);
        if constexpr (BASIS) {
            const Pack zero = fill(0.0);
            for (int k = 0; k < kColumns; ++k) {
                basis.left[k] = basis.right[k] = zero;
                const int own = seat_of(0, k);
                if (own < W)
                    basis.left[k][own] = 1.0;
                else
                    basis.right[k][own - W] = 1.0;
            }
        }
        const Sums before = sums_of(w);
        double longest = 0.0;
        for (int pair = 0; pair < kPairs; ++pair) {
            longest = max(longest, before.xx[pair] * kNoise);
            longest = max(longest, before.yy[pair] * kNoise);
        }
        noise = fill(longest);
        for (int sweeps = 0; sweeps < kMaxSweeps; ++sweeps) {
            unsettled = noise != noise;
            sweep(std::make_integer_sequence<int, kColumns - 1>());
            if (!any(unsettled)) break;
        }
        write(matrix, sigma, vectors);
    }

    // Row k of a matrix by columns, in the seats of the first round
    static void seat(const double* matrix, int rows, int k, Seated<ROWS>& out) {
        Pack left = fill(0.0), right = left;
        for (int pair = 0; pair < kPairs; ++pair) {
            left[pair] = matrix[kSchedule.left[0][pair] * rows + k];
            right[pair] = matrix[kSchedule.right[0][pair] * rows + k];
        }
        out.left[k] = left, out.right[k] = right;
    }

    // In descending order of the lengths; equal ones stay in theirs
    void write(double* matrix, double* sigma, double* vectors) const {
        const Sums after = sums_of(w);
        const Pack lengths[2] = {sqrt(after.xx), sqrt(after.yy)};
        int order[kColumns];
        double size[kColumns];
        for (int column = 0; column < kColumns; ++column) {
            const int seat = seat_of(0, column);
            const double own = seat < W ? lengths[0][seat] : lengths[1][seat - W];
            int place = column;
            for (; place > 0 && size[place - 1] < own; --place) size[place] = size[place - 1], order[place] = order[place - 1];
            size[place] = own, order[place] = column;
        }
        for (int place = 0; place < kColumns; ++place) {
            sigma[place] = size[place];
            for (int k = 0; k < ROWS; ++k) matrix[place * ROWS + k] = w.at(order[place], k);
            if constexpr (BASIS)
                for (int k = 0; k < kColumns; ++k) vectors[place * kColumns + k] = basis.at(order[place], k);
        }
    }
};

template <int ROWS>
inline void take_apart(double* matrix, double* sigma, double* vectors) {
    if (vectors)
        Jacobi<ROWS, true>().run(matrix, sigma, vectors);
    else
        Jacobi<ROWS, false>().run(matrix, sigma, nullptr);
}

}  // namespace rankdrop::RANKDROP_ISA::single_svd
#endif

namespace rankdrop::RANKDROP_ISA {

// A matrix by columns, as `svd` with the precision `kExact`; false, and nothing done, where this size or this build has no
// other way than that one.
inline bool svd_of_single([[maybe_unused]] double* matrix, [[maybe_unused]] int rows, [[maybe_unused]] int columns,
                          [[maybe_unused]] double* sigma, [[maybe_unused]] double* vectors) {
#if RANKDROP_WIDTH >= 4
    if (columns != single_svd::kColumns || (rows != 6 && rows != 7)) return false;
    rows == 7 ? single_svd::take_apart<7>(matrix, sigma, vectors) : single_svd::take_apart<6>(matrix, sigma, vectors);
    return true;
#else
    return false;
#endif
}

// As `svd` where all lanes hold the same matrix.
inline void svd_of_equal(Pack* w, int rows, int columns, Precision precision, Pack* sigma, Pack* basis) {
    double matrix[42], sizes[6], vectors[36];
    const int entries = rows * columns;
    const bool small = columns == 6 && rows <= 7;
    for (int i = 0; small && i < entries; ++i) matrix[i] = get(w[i], 0);
    if (!small || !svd_of_single(matrix, rows, columns, sizes, vectors)) return svd(w, rows, columns, precision, sigma, basis);
    for (int i = 0; i < entries; ++i) w[i] = fill(matrix[i]);
    for (int i = 0; i < columns; ++i) sigma[i] = fill(sizes[i]);
    for (int i = 0; i < columns * columns; ++i) basis[i] = fill(vectors[i]);
}

}  // namespace rankdrop::RANKDROP_ISA
