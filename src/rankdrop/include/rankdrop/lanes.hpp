// Lanes: a pack of W doubles, one configuration per lane, and the few operations the kernels need on it.
// Every operation acts on each lane alone, in the same order whatever W is, so that a configuration's result does not
// depend on the width, on its neighbours, or on the machine (the core is built without contraction of a*b + c).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

// The same headers are compiled once per instruction set; each build lives in a namespace of its own.
#ifndef RANKDROP_ISA
#define RANKDROP_ISA baseline
#endif
#ifndef RANKDROP_WIDTH
#if defined(__GNUC__) && defined(__AVX2__)
#define RANKDROP_WIDTH 4
#elif defined(__GNUC__)
#define RANKDROP_WIDTH 2
#else
#define RANKDROP_WIDTH 1
#endif
#endif

// The loop that follows is unrolled where its length is known: by itself -O2 leaves most loops over rows as they are.
#if defined(__clang__)
#define RANKDROP_UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define RANKDROP_UNROLL _Pragma("GCC unroll 6")
#else
#define RANKDROP_UNROLL
#endif

namespace rankdrop::RANKDROP_ISA {

inline constexpr int W = RANKDROP_WIDTH;

#if RANKDROP_WIDTH > 1
using Pack = double __attribute__((vector_size(8 * RANKDROP_WIDTH)));
using Mask = long long __attribute__((vector_size(8 * RANKDROP_WIDTH)));
inline double get(const Pack& x, int lane) { return x[lane]; }
inline void set(Pack& x, int lane, double value) { x[lane] = value; }
inline bool get(const Mask& x, int lane) { return x[lane] != 0; }
inline Pack fill(double value) { return Pack{} + value; }
using Rough = float __attribute__((vector_size(4 * RANKDROP_WIDTH)));
#if RANKDROP_WIDTH == 8 && defined(__AVX512F__)  // compilers convert by halves, through memory
inline Rough rough(const Pack& x) { return (Rough)_mm512_maskz_cvtpd_ps((__mmask8)0xFF, (__m512d)x); }
inline Pack fine(const Rough& x) { return (Pack)_mm512_maskz_cvtps_pd((__mmask8)0xFF, (__m256)x); }
#elif RANKDROP_WIDTH == 4 && defined(__AVX__)
inline Rough rough(const Pack& x) { return (Rough)_mm256_cvtpd_ps((__m256d)x); }
inline Pack fine(const Rough& x) { return (Pack)_mm256_cvtps_pd((__m128)x); }
#else
inline Rough rough(const Pack& x) { return __builtin_convertvector(x, Rough); }
inline Pack fine(const Rough& x) { return __builtin_convertvector(x, Pack); }
#endif
// the power of two that brings x between 1 and 4 (zero and infinities: some power of two)
inline Pack to_unit(const Pack& x) { return (Pack)(0x7FE0000000000000LL - ((Mask)x & 0x7FF0000000000000LL)); }
#else
using Pack = double;
using Mask = bool;
inline double get(const Pack& x, int) { return x; }
inline void set(Pack& x, int, double value) { x = value; }
inline bool get(const Mask& x, int) { return x; }
inline Pack fill(double value) { return value; }
using Rough = float;
inline Rough rough(Pack x) { return (float)x; }
inline Pack fine(Rough x) { return x; }
inline Pack to_unit(Pack x) {
    std::int64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    bits = 0x7FE0000000000000LL - (bits & 0x7FF0000000000000LL);
    std::memcpy(&x, &bits, sizeof bits);
    return x;
}
#endif

#if RANKDROP_WIDTH > 1
// the same of one number, for code that serves packs and single configurations
inline double select(bool mask, double yes, double no) { return mask ? yes : no; }
inline double abs(double x) { return std::fabs(x); }
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline double sqrt(double x) { return std::sqrt(x); }
inline bool any(bool mask) { return mask; }
#endif
inline Pack select(Mask mask, Pack yes, Pack no) { return mask ? yes : no; }
#if RANKDROP_WIDTH > 1
inline Pack abs(Pack x) { return (Pack)((Mask)x & 0x7FFFFFFFFFFFFFFFLL); }
// x with its sign changed where those of a and b differ
inline Pack turned(Pack x, Pack a, Pack b) { return (Pack)((Mask)x ^ (((Mask)a ^ (Mask)b) & ~0x7FFFFFFFFFFFFFFFLL)); }
#else
inline Pack abs(Pack x) { return std::fabs(x); }
inline Pack turned(Pack x, Pack a, Pack b) { return std::signbit(a) != std::signbit(b) ? -x : x; }
#endif
inline Pack max(Pack a, Pack b) { return select(a > b, a, b); }
inline Pack min(Pack a, Pack b) { return select(a < b, a, b); }

inline bool any(Mask mask) {
#if RANKDROP_WIDTH == 8 && defined(__AVX512DQ__)
    return _mm512_movepi64_mask((__m512i)mask) != 0;
#elif RANKDROP_WIDTH == 4 && defined(__AVX2__)
    return _mm256_movemask_pd((__m256d)mask) != 0;
#else
    for (int lane = 0; lane < W; ++lane)
        if (get(mask, lane)) return true;
    return false;
#endif
}

inline Pack sqrt(Pack x) {
#if RANKDROP_WIDTH == 8 && defined(__AVX512F__)
    return (Pack)_mm512_maskz_sqrt_pd((__mmask8)0xFF, (__m512d)x);  // all lanes: compilers warn of the plain one
#elif RANKDROP_WIDTH == 4 && defined(__AVX__)
    return (Pack)_mm256_sqrt_pd((__m256d)x);
#elif RANKDROP_WIDTH == 2 && defined(__SSE2__)
    return (Pack)_mm_sqrt_pd((__m128d)x);
#else
    Pack y = x;
    for (int lane = 0; lane < W; ++lane) set(y, lane, std::sqrt(get(x, lane)));
    return y;
#endif
}

inline Rough max(Rough a, Rough b) {
#if RANKDROP_WIDTH == 8 && defined(__AVX512F__)
    return (Rough)_mm256_max_ps((__m256)a, (__m256)b);
#elif RANKDROP_WIDTH == 4 && defined(__AVX__)
    return (Rough)_mm_max_ps((__m128)a, (__m128)b);
#else
    return a > b ? a : b;
#endif
}

inline Rough sqrt(Rough x) {
#if RANKDROP_WIDTH == 8 && defined(__AVX512F__)
    return (Rough)_mm256_sqrt_ps((__m256)x);
#elif RANKDROP_WIDTH == 4 && defined(__AVX__)
    return (Rough)_mm_sqrt_ps((__m128)x);
#elif RANKDROP_WIDTH > 1
    for (int lane = 0; lane < W; ++lane) x[lane] = std::sqrt(x[lane]);
    return x;
#else
    return std::sqrt(x);
#endif
}

// sin and cos together: reduction by pi/2 in three parts (33 + 33 + 53 bits), then the minimax polynomials on
// [-pi/4, pi/4] whose coefficients are those published with fdlibm (Sun, 1993). Error below 1 ulp for |x| < 1e5;
// larger arguments go to the C library.
inline void sincos(Pack x, Pack& sine, Pack& cosine) {
    const Pack shift = fill(6755399441055744.0);  // 1.5 * 2^52: adding it rounds to an integer
    const Pack turns = (x * fill(6.36619772367581382433e-01) + shift) - shift;
    Pack r = x - turns * fill(1.57079632673412561417e+00);
    r = r - turns * fill(6.07710050630396597660e-11);
    r = r - turns * fill(2.02226624879595063154e-21);
    const Pack z = r * r;
    const Pack s =
        r + r * z *
                (fill(-1.66666666666666324348e-01) +
                 z * (fill(8.33333333332248946124e-03) +
                      z * (fill(-1.98412698298579493134e-04) +
                           z * (fill(2.75573137070700676789e-06) +
                                z * (fill(-2.50507602534068634195e-08) + z * fill(1.58969099521155010221e-10))))));
    const Pack half = fill(0.5) * z;
    const Pack head = fill(1.0) - half;
    const Pack c =
        head + ((fill(1.0) - head - half) +
                z * z *
                    (fill(4.16666666666666019037e-02) +
                     z * (fill(-1.38888888888741095749e-03) +
                          z * (fill(2.48015872894767294178e-05) +
                               z * (fill(-2.75573143513906633035e-07) +
                                    z * (fill(2.08757232129817482790e-09) + z * fill(-1.13596475577881948265e-11)))))));
    // quadrant: turns modulo 4, without integers
    const Pack quarter = turns * fill(0.25);
    const Pack whole = (quarter + shift) - shift;
    const Pack quadrant = turns - fill(4.0) * whole;  // -2 … 2
    const Mask odd = abs(quadrant) == fill(1.0);
    const Mask half_turn = abs(quadrant) == fill(2.0);
    const Pack ss = select(odd, c, s);
    const Pack cc = select(odd, s, c);
    const Mask negative_sine = (quadrant == fill(-1.0)) | half_turn;
    const Mask negative_cosine = (quadrant == fill(1.0)) | half_turn;
    sine = select(negative_sine, -ss, ss);
    cosine = select(negative_cosine, -cc, cc);
    const Mask large = abs(x) > fill(1e5);
    if (!any(large)) return;
    for (int lane = 0; lane < W; ++lane) {
        if (!get(large, lane)) continue;
        set(sine, lane, std::sin(get(x, lane)));
        set(cosine, lane, std::cos(get(x, lane)));
    }
}

// Row-major memory, one configuration per row, to and from lanes. Lanes past `count` repeat the last row.
inline void load(const double* rows, std::ptrdiff_t stride, int count, int columns, Pack* out) {
    for (int lane = 0; lane < W; ++lane) {
        const double* row = rows + stride * (lane < count ? lane : count - 1);
        for (int j = 0; j < columns; ++j) set(out[j], lane, row[j]);
    }
}

#if RANKDROP_WIDTH > 1
#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define RANKDROP_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#endif
#endif
#if !defined(RANKDROP_SHUFFLE)
#define RANKDROP_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, Mask{__VA_ARGS__})
#endif
#endif

// W packs, the rows of a matrix, become its columns: single entries change places first, then pairs, then fours.
inline void transpose(Pack* x) {
#if RANKDROP_WIDTH > 1
    const auto change = [&](int apart, auto low, auto high) {
        for (int i = 0; i < W; ++i) {
            if (i & apart) continue;
            const Pack a = x[i], b = x[i + apart];
            x[i] = low(a, b), x[i + apart] = high(a, b);
        }
    };
#endif
#if RANKDROP_WIDTH == 2
    change(1, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 2); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 1, 3); });
#elif RANKDROP_WIDTH == 4
    change(1, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 4, 2, 6); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 1, 5, 3, 7); });
    change(2, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 1, 4, 5); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 2, 3, 6, 7); });
#elif RANKDROP_WIDTH == 8
    change(1, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 8, 2, 10, 4, 12, 6, 14); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 1, 9, 3, 11, 5, 13, 7, 15); });
    change(2, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15); });
    change(4, [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11); },
           [](Pack a, Pack b) { return RANKDROP_SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15); });
#else
    static_cast<void>(x);
#endif
}

// `next` gives the entries of a row one after the other, in lanes; the rows are written one after the other, in whole
// packs. `room` holds `columns` packs.
template <class Next>
inline void store_each(Next next, int columns, int count, double* rows, std::ptrdiff_t stride, Pack* room) {
    for (int j = 0; j < columns; ++j) room[j] = next();
    const int whole = count == W ? columns / W * W : 0;
    for (int j = 0; j < whole; j += W) transpose(room + j);
    for (int lane = 0; lane < count; ++lane) {
        double* row = rows + stride * lane;
        for (int j = 0; j < whole; j += W) std::memcpy(row + j, room + j + lane, sizeof(Pack));
        for (int j = whole; j < columns; ++j) row[j] = get(room[j], lane);
    }
}

// Leaves `in` in another order.
inline void store(Pack* in, int columns, int count, double* rows, std::ptrdiff_t stride) {
    store_each([&, j = 0]() mutable { return in[j++]; }, columns, count, rows, stride, in);
}

}  // namespace rankdrop::RANKDROP_ISA
