// Split: the determinant of a 6R arm as a dot product of two vectors of six minors, in tables.
//
// Seen from the link between joints 3 and 4, modulo the axes of these two joints, the other four columns lie in a space of
// four dimensions, where
//
//     f(q) = det [S1 S2 S5 S6] = sum over the six pairs of rows of  a_t(q2, q3) b_t(q4, q5)
//
// is the determinant of the Jacobian up to a constant; q1 and q6 drop out. a_t and b_t are trigonometric polynomials of
// degree 1 in the outer variable (q2, q5) and 2 in the inner one (q3, q4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rankdrop {

inline constexpr int kMinors = 6;
inline constexpr int kWaves = 15;  // (1, cos, sin) of the outer variable by (1, cos, sin, cos 2, sin 2) of the inner one
inline constexpr int kRow = 16;    // fifteen numbers and one that is not used
inline constexpr int kSplitVariables = 4;  // q2 … q5
inline constexpr int kDeepest = 9;         // halvings of a variable: 500 MB of tables
inline constexpr int kMostHalvings = 64;    // by which a leaf is looked into
inline constexpr std::int64_t kMostParts = 4096;  // that it is looked at in
inline constexpr int kFamilySize = 16;     // children of a box that is halved in every variable

// The boxes of one level. Tables of minors with their two first derivatives at the centres; and of the minors as polynomials
// on each box, by their Bernstein coefficients in tan(d / 2), d from the centre, divided by the weight at the ends.
struct SplitLevel {
    std::array<int, kSplitVariables> cells{};    // along each variable
    std::array<int, kSplitVariables> halved{};   // 1 where the level above has half as many
    std::array<double, kSplitVariables> half{};  // half-widths, rounded outwards [rad]
    double slack = 0.0;                          // remainder of the Taylor series of first order, and rounding
    std::vector<double> a;                       // (cells 2, cells 3, 3, 6)
    std::vector<double> b;                       // (parent's cells 4, parent's cells 5, 3, 6, 4): four children side by side
    std::vector<double> shape_a;                 // (cells 2, cells 3, 15, 6)
    std::vector<double> shape_b;                 // (cells 4, cells 5, 6, 16)
    std::uint16_t children = 0;                  // which of the 16 there are
};

struct Split {
    std::array<double, kSplitVariables> lower{}, upper{};
    std::array<int, kSplitVariables> depth{};  // halvings of each variable
    int depths = 0;                            // the largest of them, at least 1: the level of the leaves
    int top = 0;                               // the level whose boxes are worked on one by one
    int further = 0;                           // halvings by which leaves are looked into
    double rounding = 0.0;                     // |f computed - f|, at most
    std::vector<SplitLevel> levels;            // 0 … depths

    std::int64_t trees() const {  // boxes of the level `top`
        std::int64_t count = 1;
        for (const int cells : levels[static_cast<std::size_t>(top)].cells) count *= cells;
        return count;
    }
};

struct SplitSettings {
    const double *a, *b;           // (6, 15) coefficients
    const double *lower, *upper;   // (4) [rad]
    const int* depth;              // (4)
    const double* curvature;       // (4, 4) bounds of |d2 f / dq_j dq_k|
    double rounding, slope;        // |f computed - f| and |df/dq_j computed - df/dq_j|, at most
    int further;                   // halvings by which leaves are looked into
    int top;
};

Split make_split(const SplitSettings& settings);

// What is left of one box of the level `top`: masks of the children that are not free, level by level, last those of the
// leaves that are proven to hold a singularity.
struct CoverTree {
    std::vector<std::vector<std::uint16_t>> masks;  // (depths - top + 1)
    std::int64_t tested = 0, freed = 0;             // boxes; leaves freed by looking into them
};

}  // namespace rankdrop
