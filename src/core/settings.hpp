// What a search is told, and what it says of each start. Plain data shared by every instruction set.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "enclosing.hpp"

namespace rankdrop {

enum Outcome : std::int8_t { kConverged = 0, kNearMiss = 1, kSlow = 2, kNotRun = 3 };

// Block Levenberg-Marquardt; steepest descent, plain and with AM's rotation (eqs 12-14).
enum class Method { newton, descent, rotated };

struct SearchSettings {
    Method method = Method::newton;
    int rank = 0;                  // the rank to be reached; the block is what lies beyond it
    int iterations = 200;
    double singular = 1e-9;        // sigma[rank] at or below: converged
    double target = 1e-13;         // sigma[rank] at or below: stop
    double stationary = 1e-5;      // share of F inside range(D) at a nonzero local minimum
    double step = 1.0;             // largest step [rad, or length scale]
    int kicks = 2;                 // restarts from beside a local minimum before it is called a near miss
    std::uint64_t seed = 0;
    std::vector<double> scale;     // (n) 1 for angles, the length scale for lengths
    std::vector<double> lower, upper;  // (n) limits, or empty for none
    double tie = 1e-2;             // descent: relative gap below which singular values count as equal
    double share = 0.0;            // descent: of the step at whose end sigma would be zero, were it linear; 0: line search
};

// Where results go; rows are starts. `history` may be null; else (starts, iterations + 1, s), and `turning`
// (starts, iterations + 1) the angle between the gradients followed in successive iterations [rad].
struct SearchOutput {
    double* q;
    double* sigma;
    std::int8_t* outcome;
    std::int32_t* iterations;
    double* history = nullptr;
    double* turning = nullptr;
};

// One ball by branch and bound: up to `radius` of its EnclosureSettings.
struct BallSettings {
    double inner;         // a ball that is known to be free
    double enough;        // a larger one is not asked for once this is proven
    double smallest;      // boxes are not divided below this
    std::int64_t budget;  // enclosures, at most
    bool keep;            // the boxes that were proven free
};

// Uniform in [-1, 1), a function of its arguments alone (splitmix64).
inline double noise(std::uint64_t seed, std::uint64_t start, std::uint64_t kick, std::uint64_t joint) {
    std::uint64_t x = seed * 0x9E3779B97F4A7C15ull + start * 0xBF58476D1CE4E5B9ull + kick * 0x94D049BB133111EBull + joint;
    for (int round = 0; round < 2; ++round) {
        x += 0x9E3779B97F4A7C15ull;
        x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
        x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
        x ^= x >> 31;
    }
    return (double)(std::int64_t)(x >> 11) * 0x1.0p-52 - 1.0;
}

// What the walk to the nearest singular configuration is told.
struct NearestSettings {
    int rank = 0;                            // rank kept; the block is what lies beyond it
    int evaluations = 200;                   // at most, per start
    double singular = 1e-9;                  // sigma[rank] at or below: singular
    double target = 1e-13;                   // sigma[rank] at or below: on the set
    double step = 0.5;                       // longest step [rad, or length scale]
    double still = 1e-9;                     // share of the way to the centre that lies along the set, of a nearest point
    bool polish = true;                      // go on to the last digit at the end
    std::vector<double> centre;              // (n) the configuration whose distance is asked for
    std::vector<double> scale;               // (n) 1 for angles, the length scale for lengths
    std::vector<double> lower, upper;        // (n) limits, or empty for none
};

// Rows are starts; distance and stationarity are infinite where a start did not stay on the set.
struct NearestOutput {
    double* q;
    double* distance;      // |q - centre|, scaled
    double* stationarity;  // share of q - centre that lies along the set
    std::int32_t* evaluations;
};

// How feet of a configuration on the singular set are looked for. Lengths are in scaled joint coordinates.
struct SetFeetSettings {
    int iterations = 10;
    double still = 1e-4;                     // a walk whose step gets shorter has arrived
    double longest = 0.7;                    // step
    double flattest = 5e-2;                  // curvatures are taken for at least this
    double farthest = HUGE_VAL;              // feet beyond this are of no interest
    double off = 1e-6;                       // sigma at a foot is at most this
    std::vector<double> centre;              // (n) the configuration whose feet are asked for
    std::vector<double> scale;               // (n) 1 for angles, the length scale for lengths
    std::vector<double> turn;                // (n) a motion that is none: 2 pi for angles, 0 for lengths
};

enum Met : std::int8_t { kArrived = 0, kFarther = 1, kLost = 2, kNowhere = 3 };  // nowhere: where nothing is singular

inline constexpr std::size_t kMostEquations = 200;  // that are solved together, or joints that may move: kMaxColumns of an SVD

// How common zeros of equations are looked for.
struct ZeroSettings {
    int iterations = 40;
    double step = 0.5;                       // longest step [rad, or unit of a slide]
    double still = 1e-14;                    // a start whose step gets shorter has arrived
    double enough = 1e-15;                   // as has one where no |f| is larger
    double cut = 1e-7;                       // singular values below this share of the largest are not inverted
    std::vector<double> along;               // (n, d) orthonormal basis of the directions that may be used, or empty for all
};

// How the nearest points of a family are looked for. Steps are in scaled joint coordinates.
struct FootSettings {
    int leading = 1;                         // equations that are walked on: the first of them
    int iterations = 25;
    int returns = 3;                         // steps straight onto the family at the end
    double still = 1e-9;                     // a start whose step gets shorter stands still
    double longest = 0.7;                    // step
    double cut = 1e-7;                       // singular values below this share of the largest are not inverted
    double flattest = 1e-2;                  // curvatures are taken for at least this
    double farthest = HUGE_VAL;              // feet beyond this are of no interest
    std::vector<double> target;              // (n) the configuration to stay near to
    std::vector<double> scale;               // (n) 1 for angles, the length scale for lengths
    std::vector<int> periodic;               // (n) 1: a turn of 2 pi is no motion
    std::vector<int> columns;                // joints that move
    std::vector<double> lower, upper;        // (n) limits, or empty for none
};

}  // namespace rankdrop
