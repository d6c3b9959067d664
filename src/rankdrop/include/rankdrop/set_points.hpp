// Points of the singular set, and those of them that are nearest to a configuration.
#pragma once

#include <algorithm>
#include <cmath>

#include "families.hpp"
#include "memory.hpp"

namespace rankdrop::RANKDROP_ISA {

inline constexpr double kTurn = 6.283185307179586;
inline constexpr int kNearPoints = 7;  // that walks of one configuration begin at
inline constexpr int kVisited = 8;     // groups of points that are looked through

// Scratch of `nearest_points`.
struct PointRoom {
    float* far;

    explicit PointRoom(Arena& arena) : far(arena.take<float>(kMostOfGroup)) {}
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

// The K least of them in order; of equals the first.
template <int K>
struct Least {
    float square[K];
    int number[K];

    Least() { std::fill(square, square + K, HUGE_VALF), std::fill(number, number + K, 0); }

    void add(const float* squares, int count, int first) {
        constexpr int kBlock = 16;  // looked at together: most hold nothing
        for (int i = 0; i < count; ++i) {
            if (i % kBlock == 0 && i + kBlock <= count) {
                float least = squares[i];
                for (int k = 1; k < kBlock; ++k) least = std::min(least, squares[i + k]);
                if (least >= square[K - 1]) {
                    i += kBlock - 1;
                    continue;
                }
            }
            if (squares[i] >= square[K - 1]) continue;
            int at = K - 1;
            for (; at > 0 && squares[i] < square[at - 1]; --at) square[at] = square[at - 1], number[at] = number[at - 1];
            square[at] = squares[i], number[at] = first + i;
        }
    }
};

// The points nearest to q, over the joints that matter, in the groups whose centres are nearest. q: (n).
inline void nearest_points(const SetPoints& set, const double* q, PointRoom& room, int* out) {
    float at[kMostMoving];
    const int joints = (int)set.moving.size(), groups = (int)set.first.size() - 1;
    for (int j = 0; j < joints; ++j) at[j] = (float)(q[set.moving[(std::size_t)j]] / kTurn);
    Least<kVisited> near_groups;
    squares_to(set.centre.data(), groups, at, joints, room.far);
    near_groups.add(room.far, groups, 0);
    Least<kNearPoints> found;
    for (int visit = 0; visit < kVisited; ++visit) {
        const int group = near_groups.number[visit], first = set.first[(std::size_t)group];
        const int count = set.first[(std::size_t)group + 1] - first;
        squares_to(set.place.data() + (std::ptrdiff_t)first * joints, count, at, joints, room.far);
        found.add(room.far, count, first);
    }
    std::copy(found.number, found.number + kNearPoints, out);
}

}  // namespace rankdrop::RANKDROP_ISA
