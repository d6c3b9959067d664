// Points of the singular set, and those of them that are nearest to a configuration.
#pragma once

#include <algorithm>
#include <cmath>

#include "families.hpp"
#include "memory.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr double kTurn = 6.283185307179586;
inline constexpr int kNearPoints = 6;  // that walks of one configuration begin at
inline constexpr int kVisited = 10;    // groups of points that are looked through
inline constexpr int kLanes = 32;      // squares that are compared at once

// Scratch of `nearest_points`.
struct PointRoom {
    float* far;

    explicit PointRoom(Arena& arena) : far(arena.take<float>(kMostOfGroup + kLanes)) {}
};

// Squares of distances from `at` to `count` places (joints, count), in turns.
inline void squares_to(const float* places, int count, const float* at, int joints, float* out) {
    const float round = 12582912.0f;  // 1.5 * 2^23
    for (int i = 0; i < count; ++i) out[i] = 0.0f;
    for (int j = 0; j < joints; ++j, places += count) {
        const float here = at[j];
        for (int i = 0; i < count; ++i) {
            const float apart = places[i] - here, gap = apart - ((apart + round) - round);
            out[i] += gap * gap;
        }
    }
}

// Of every kLanes-th place the nearest: nearly the nearest of all, and found without a branch.
struct Nearest {
    float square[kLanes];
    int number[kLanes];

    Nearest() { std::fill(square, square + kLanes, HUGE_VALF), std::fill(number, number + kLanes, 0); }

    // `squares` has room for a multiple of kLanes.
    void add(float* squares, int count, int first) {
        for (int i = count; i % kLanes; ++i) squares[i] = HUGE_VALF;
        for (int i = 0; i < count; i += kLanes)
            for (int k = 0; k < kLanes; ++k) {
                const bool nearer = squares[i + k] < square[k];
                square[k] = nearer ? squares[i + k] : square[k], number[k] = nearer ? first + i + k : number[k];
            }
    }

    // The `count` nearest of them in order; of equals the first.
    void take(int count, int* out) const {
        float least[kLanes];
        for (int k = 0; k < kLanes; ++k) {
            int at = k < count ? k : count;
            for (; at > 0 && square[k] < least[at - 1]; --at)
                if (at < count) least[at] = least[at - 1], out[at] = out[at - 1];
            if (at < count) least[at] = square[k], out[at] = number[k];
        }
    }
};

// The points nearest to q, over the joints that matter, in the groups whose centres are nearest. q: (n).
inline void nearest_points(const SetPoints& set, const double* q, PointRoom& room, int* out) {
    float at[kMostMoving];
    const int joints = (int)set.moving.size(), groups = (int)set.first.size() - 1;
    for (int j = 0; j < joints; ++j) at[j] = (float)(q[set.moving[(std::size_t)j]] / kTurn);
    Nearest centres, points;
    int visited[kVisited];
    squares_to(set.centre.data(), groups, at, joints, room.far);
    centres.add(room.far, groups, 0), centres.take(kVisited, visited);
    for (const int group : visited) {
        const int first = set.first[(std::size_t)group];
        const int count = set.first[(std::size_t)group + 1] - first;
        squares_to(set.place.data() + (std::ptrdiff_t)first * joints, count, at, joints, room.far);
        points.add(room.far, count, first);
    }
    points.take(kNearPoints, out);
    for (int i = 0; i < kNearPoints; ++i)
        __builtin_prefetch(set.point(out[i])), __builtin_prefetch(set.point(out[i]) + 16);
}

}  // namespace rankdrop::RANKDROP_ISA
