// Points of the singular set, and those of them that are nearest to a configuration.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "families.hpp"
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

// Squares of distances from `at` to the places of one block (joints, kBlock), in quarters of parts of a turn.
inline void squares_to(const std::int16_t* places, const std::int16_t* at, int joints, std::int32_t* out) {
    for (int k = 0; k < kBlock; ++k) out[k] = 0;
    for (int j = 0; j < joints; ++j, places += kBlock) {
        const std::int16_t here = at[j];
        for (int k = 0; k < kBlock; ++k) {
            const std::int16_t gap = (std::int16_t)((std::int16_t)(std::uint16_t)(places[k] - here) >> 2);
            out[k] += (std::int32_t)gap * gap;
        }
    }
}

// Of every kBlock-th place the nearest: nearly the nearest of all, and found without a branch.
struct Nearest {
    std::int32_t square[kBlock];
    std::int32_t number[kBlock];

    Nearest() { std::fill(square, square + kBlock, kFarthest), std::fill(number, number + kBlock, 0); }

    // Places in blocks, the first of them number `first`.
    void add(const std::int16_t* places, int count, int first, const std::int16_t* at, int joints) {
        for (int block = 0; block < count; block += kBlock, places += kBlock * joints) {
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
        std::int32_t least[kBlock];
        for (int k = 0; k < kBlock; ++k) {
            int at = k < count ? k : count;
            for (; at > 0 && square[k] < least[at - 1]; --at)
                if (at < count) least[at] = least[at - 1], out[at] = out[at - 1];
            if (at < count) least[at] = square[k], out[at] = number[k];
        }
    }
};

// The points nearest to q, over the joints that matter, in the groups whose centres are nearest. q: (n).
inline void nearest_points(const SetPoints& set, const double* q, int* out) {
    std::int16_t at[kMostMoving];
    const int joints = (int)set.moving.size(), groups = (int)set.first.size() - 1;
    for (int j = 0; j < joints; ++j) at[j] = parts_of_turn(q[set.moving[(std::size_t)j]]);
    Nearest centres, points;
    int visited[kVisited];
    centres.add(set.centre.data(), groups, 0, at, joints), centres.take(kVisited, visited);
    for (const int group : visited) {
        const int first = set.first[(std::size_t)group], count = set.first[(std::size_t)group + 1] - first;
        points.add(set.place.data() + set.first_place[(std::size_t)group], count, first, at, joints);
    }
    points.take(kNearPoints, out);
    for (int i = 0; i < kNearPoints; ++i)
        __builtin_prefetch(set.point(out[i])), __builtin_prefetch(set.point(out[i]) + 16);
}

}  // namespace rankdrop::RANKDROP_ISA
