// Newton's method towards poses of the tip, row by row; back to where a task began; and poses on the straight moves between
// given ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels.hpp"

namespace rankdrop {

// What a task asks of the pose of the tip.
struct AimSettings {
    std::vector<int> rows;       // of (p* - p ; log(R* R^T)), 0 ... 5
    double length;               // translations are divided by it
    double point[3];             // of reference, in the axes of the tip
    bool with_tip;               // rows are in the axes of the tip, not of the base
    int free, heading;           // axis about which the tool may turn; axis that is the only one to be turned about; -1: none
    std::vector<double> joints;  // scale of each joint
};

// How far Newton's method goes.
struct NewtonSettings {
    double close;  // |e| of a solution
    int rounds;
    bool far;  // damped, steps cut short
};

// A chain, its six rows or fewer at the tip, and what is asked of it.
struct Aim {
    const Chain& chain;
    const View& view;
    const AimSettings& settings;

    std::size_t n() const { return static_cast<std::size_t>(chain.variables); }
    std::size_t m() const { return settings.rows.size(); }
};

// The displacement of a task from a start: rows of (A^T (p - p0); A^T log(R R0^T)), each times its scale.
struct DisplacementSettings {
    std::vector<int> rows;          // 0 ... 5
    std::vector<double> row_scale;  // of each row
    std::vector<double> joints;     // scale of each joint
    double point[3];                // of reference p, in the axes of the tip
    double axes[3][3];              // A: columns are axes, in those of the base
    double home[16];                // pose of the tip at the start
};

// How far Gauss-Newton goes back to the start.
struct BackSettings {
    double weak;     // sigma below which a direction is left alone
    double longest;  // step [rad; slides scaled]
    double still;    // a step no longer than this is the last one
    int rounds;
};

// now, goals (B, 4, 4) -> e (B, m)
void aim_errors(const AimSettings&, const double* now, const double* goals, std::size_t count, double* errors);
// J^T (J J^T + lambda)^-1 e: q (B, n), e (B, m), lambda (B) or null -> (B, n)
void aim_steps(const Aim&, const double* q, const double* errors, const double* damping, std::size_t count, double* steps);
// q (B, n) in and out; when (B): the number of steps after which each arrived, -1 where it did not
void aim_newton(const Aim&, const NewtonSettings&, const double* goals, std::size_t count, double* q, std::int64_t* when);
// q (B, n) in and out, by shortest steps, `six` all rows at the point in axes of the base; off (B): |d| that is left
void displacement_back(const Chain&, const View& six, const DisplacementSettings&, const BackSettings&, std::size_t count,
                       double* q, double* off);
// poses (P, 4, 4), places (B) counted from 0 -> (B, 4, 4)
void poses_at(const double* poses, std::size_t poses_count, const double* places, std::size_t count, double* out);

}  // namespace rankdrop
