// Points of the singular set, and those of them that are nearest to a configuration.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "families.hpp"
#include "lanes.hpp"
#include "memory.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr double kTurn = 6.283185307179586;
inline constexpr int kNearPoints = 6;  // that walks of one configuration begin at
inline constexpr std::int32_t kFarthest = 0x7FFFFFFF;
inline constexpr int kVisited = 16;    // groups of points that are looked through

// An angle in parts of a turn: differences of whole turns vanish as the numbers overflow.
inline std::int16_t parts_of_turn(double angle) {
    const double turns = angle / kTurn;
    return (std::int16_t)(std::uint16_t)(std::int32_t)((turns - std::floor(turns)) * 65536.0);
}

// Joints as they lie in blocks: in pairs, the last one with a joint that is always 0.
inline int paired(int joints) { return (joints + 1) / 2 * 2; }

// Squares of distances from `at` to the places of one block (paired joints / 2, kBlock, 2), in quarters of parts of a turn.
inline void squares_to(const std::int16_t* places, const std::int16_t* at, int joints, std::int32_t* out) {
#if defined(__AVX2__)
    static_assert(kBlock == 32, "four sums of eight places: in registers only where they have names of their own");
    __m256i first = _mm256_setzero_si256(), second = first, third = first, fourth = first;
    for (int j = 0; j < joints; j += 2, places += 2 * kBlock) {
        std::int32_t both;
        std::memcpy(&both, at + j, sizeof both);
        const __m256i here = _mm256_set1_epi32(both);
        const auto add = [places, here](__m256i sum, int part) {
            const __m256i there = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(places) + part);
            const __m256i gap = _mm256_srai_epi16(_mm256_sub_epi16(there, here), 2);
            return _mm256_add_epi32(sum, _mm256_madd_epi16(gap, gap));
        };
        first = add(first, 0), second = add(second, 1), third = add(third, 2), fourth = add(fourth, 3);
    }
    __m256i* to = reinterpret_cast<__m256i*>(out);
    _mm256_storeu_si256(to, first), _mm256_storeu_si256(to + 1, second);
    _mm256_storeu_si256(to + 2, third), _mm256_storeu_si256(to + 3, fourth);
#else
    for (int k = 0; k < kBlock; ++k) out[k] = 0;
    for (int j = 0; j < joints; j += 2, places += 2 * kBlock)
        for (int k = 0; k < kBlock; ++k)
            for (int own = 0; own < 2; ++own) {
                const std::int16_t gap = (std::int16_t)((std::int16_t)(std::uint16_t)(places[2 * k + own] - at[j + own]) >> 2);
                out[k] += (std::int32_t)gap * gap;
            }
#endif
}

// Of every kBlock-th place the nearest: nearly the nearest of all, and found without a branch.
struct Nearest {
    std::int32_t square[kBlock];
    std::int32_t number[kBlock];

    Nearest() { std::fill(square, square + kBlock, kFarthest), std::fill(number, number + kBlock, 0); }

    // Places in blocks, the first of them number `first`.
    void add(const std::int16_t* places, int count, int first, const std::int16_t* at, int joints) {
        for (int block = 0; block < count; block += kBlock, places += kBlock * paired(joints)) {
            std::int32_t squares[kBlock];
            squares_to(places, at, joints, squares);
            for (int k = count - block; k < kBlock; ++k) squares[k] = kFarthest;
            for (int k = 0; k < kBlock; ++k) {
                const bool nearer = squares[k] < square[k];
                square[k] = nearer ? squares[k] : square[k], number[k] = nearer ? first + block + k : number[k];
            }
        }
    }

    // The `count` nearest of them in order; of equals the first.
    void take(int count, int* out) const {
        std::int32_t order[kBlock] = {};  // how many are before each
        for (int i = 0; i < kBlock; ++i) {
            const std::int32_t own = square[i];
            for (int k = 0; k < kBlock; ++k) order[k] += (own < square[k]) | ((own == square[k]) & (i < k));
        }
        for (int k = 0; k < kBlock; ++k)
            if (order[k] < count) out[order[k]] = number[k];
    }
};

// The first blocks of a group, which the processor cannot foresee.
inline void fetch_ahead(const std::int16_t* places) {
    constexpr int kLine = 64 / (int)sizeof(std::int16_t), kLines = 12;
    for (int line = 0; line < kLines; ++line) __builtin_prefetch(places + line * kLine);
}

// The points nearest to q, over the joints that matter, in the groups whose centres are nearest. q: (n).
inline void nearest_points(const SetPoints& set, const double* q, int* out) {
    std::int16_t at[kMostMoving + 1] = {};
    const int joints = (int)set.moving.size(), groups = (int)set.first.size() - 1;
    for (int j = 0; j < joints; ++j) at[j] = parts_of_turn(q[set.moving[(std::size_t)j]]);
    Nearest centres, points;
    int visited[kVisited];
    centres.add(set.centre.data(), groups, 0, at, joints), centres.take(kVisited, visited);
    const auto first_place = [&set](int group) { return set.place.data() + set.first_place[(std::size_t)group]; };
    for (int i = 0; i < kVisited; ++i) {
        const int group = visited[i];
        if (i + 1 < kVisited) fetch_ahead(first_place(visited[i + 1]));
        const int first = set.first[(std::size_t)group], count = set.first[(std::size_t)group + 1] - first;
        points.add(first_place(group), count, first, at, joints);
    }
    points.take(kNearPoints, out);
    for (int i = 0; i < kNearPoints; ++i)
        __builtin_prefetch(set.point(out[i])), __builtin_prefetch(set.point(out[i]) + 16);
}

}  // namespace rankdrop::RANKDROP_ISA
