#include "split.hpp"

#include <algorithm>
#include <cmath>

#include "lanes.hpp"

namespace rankdrop {
namespace {

constexpr int kOuter = 3, kInner = 5;

// Values and derivatives of (1, cos, sin, cos 2, sin 2) at x; the core's own sine: the same bits on every machine.
struct Waves {
    double value[kInner], slope[kInner];
};

Waves waves(double x) {
    baseline::Pack sine, cosine;
    baseline::sincos(baseline::fill(x), sine, cosine);
    const double s = baseline::get(sine, 0), c = baseline::get(cosine, 0);
    const double s2 = 2.0 * s * c, c2 = 1.0 - 2.0 * s * s;
    return {{1.0, c, s, c2, s2}, {0.0, -s, c, -2.0 * s2, 2.0 * c2}};
}

enum Part { kValue, kOuterSlope, kInnerSlope };

double sum(const double* coefficients, const Waves& outer, const Waves& inner, Part part) {
    const double* first = part == kOuterSlope ? outer.slope : outer.value;
    const double* second = part == kInnerSlope ? inner.slope : inner.value;
    double total = 0.0;
    for (int i = 0; i < kOuter; ++i) {
        double row = 0.0;
        for (int j = 0; j < kInner; ++j) row += coefficients[i * kInner + j] * second[j];
        total += row * first[i];
    }
    return total;
}

std::vector<Waves> along(double lower, double upper, int cells, bool centres) {
    std::vector<Waves> found;
    const double width = (upper - lower) / cells;
    for (int i = 0; i < cells + (centres ? 0 : 1); ++i) found.push_back(waves(lower + (centres ? i + 0.5 : i) * width));
    return found;
}

// The tables of one level, whose parents have half as many cells where `halved` is 1.
void fill_level(const SplitSettings& set, const Split& split, SplitLevel& level) {
    std::array<std::vector<Waves>, kSplitVariables> at;
    for (std::size_t j = 0; j < kSplitVariables; ++j) at[j] = along(split.lower[j], split.upper[j], level.cells[j], true);
    const std::size_t n3 = at[1].size();
    level.a.resize(at[0].size() * n3 * 3 * kMinors);
    for (std::size_t x = 0; x < at[0].size(); ++x)
        for (std::size_t y = 0; y < n3; ++y) {
            double* out = level.a.data() + (x * n3 + y) * 3 * kMinors;
            for (int t = 0; t < kMinors; ++t) {
                const double* row = set.a + t * kWaves;
                out[t] = sum(row, at[0][x], at[1][y], kValue);
                out[kMinors + t] = sum(row, at[0][x], at[1][y], kOuterSlope);
                out[2 * kMinors + t] = sum(row, at[0][x], at[1][y], kInnerSlope);
            }
        }
    const std::size_t s4 = static_cast<std::size_t>(level.halved[2]), s5 = static_cast<std::size_t>(level.halved[3]);
    const std::size_t p4 = at[2].size() >> s4, p5 = at[3].size() >> s5;
    level.b.resize(p4 * p5 * 3 * kMinors * 4);
    for (std::size_t x = 0; x < p4; ++x)
        for (std::size_t y = 0; y < p5; ++y)
            for (std::size_t lane = 0; lane < 4; ++lane) {
                const Waves& inner = at[2][(x << s4) + (s4 ? lane / 2 : 0)];
                const Waves& outer = at[3][(y << s5) + (s5 ? lane % 2 : 0)];
                double* out = level.b.data() + (x * p5 + y) * 3 * kMinors * 4 + lane;
                for (int t = 0; t < kMinors; ++t) {
                    const double* row = set.b + t * kWaves;
                    out[4 * t] = sum(row, outer, inner, kValue);
                    out[4 * (kMinors + t)] = sum(row, outer, inner, kInnerSlope);
                    out[4 * (2 * kMinors + t)] = sum(row, outer, inner, kOuterSlope);
                }
            }
}

// |f(c + d) - f(c) - grad f(c) d| <= 1/2 sum |f_jk| |d_j| |d_k|, and what f and its gradient lose to rounding.
double remainder(const SplitSettings& set, const std::array<double, kSplitVariables>& half) {
    double total = set.rounding;
    for (std::size_t j = 0; j < kSplitVariables; ++j) {
        total += set.slope * half[j];
        for (std::size_t k = 0; k < kSplitVariables; ++k) total += 0.5 * set.curvature[j * kSplitVariables + k] * half[j] * half[k];
    }
    return total * (1.0 + 1e-12);
}

void fill_corners(const SplitSettings& set, Split& split) {
    const SplitLevel& leaves = split.levels[static_cast<std::size_t>(split.depths)];
    std::array<std::vector<Waves>, kSplitVariables> at;
    for (std::size_t j = 0; j < kSplitVariables; ++j) at[j] = along(split.lower[j], split.upper[j], leaves.cells[j], false);
    for (const Waves& outer : at[0])
        for (const Waves& inner : at[1])
            for (int t = 0; t < kMinors; ++t) split.corners_a.push_back(sum(set.a + t * kWaves, outer, inner, kValue));
    for (std::size_t x = 0; x + 1 < at[2].size(); ++x)
        for (std::size_t y = 0; y + 1 < at[3].size(); ++y)
            for (int t = 0; t < kMinors; ++t)
                for (std::size_t lane = 0; lane < 4; ++lane)
                    split.corners_b.push_back(sum(set.b + t * kWaves, at[3][y + lane % 2], at[2][x + lane / 2], kValue));
}

}  // namespace

Split make_split(const SplitSettings& set) {
    Split split;
    split.depths = 1;
    for (std::size_t j = 0; j < kSplitVariables; ++j) {
        split.lower[j] = set.lower[j], split.upper[j] = set.upper[j], split.depth[j] = set.depth[j];
        split.depths = std::max(split.depths, set.depth[j]);
    }
    split.top = set.top;
    split.rounding = set.rounding;
    for (int number = 0; number <= split.depths + set.further; ++number) {
        SplitLevel level;
        for (std::size_t j = 0; j < kSplitVariables; ++j) {
            // beyond the leaves every variable is halved again
            const auto halvings = [&](int at) { return std::min(at, set.depth[j]) + std::max(0, at - split.depths); };
            level.cells[j] = 1 << halvings(number);
            level.halved[j] = number > 0 && halvings(number) > halvings(number - 1);
            const double low = split.lower[j], high = split.upper[j];
            level.half[j] = (high - low) / level.cells[j] / 2 * (1.0 + 1e-12) + 1e-15 * (1.0 + std::fabs(low) + std::fabs(high));
        }
        for (int child = 0; child < kFamilySize; ++child) {
            bool there = true;
            for (int j = 0; j < kSplitVariables; ++j)
                there = there && (level.halved[static_cast<std::size_t>(j)] || !(child >> (3 - j) & 1));
            if (there) level.children = static_cast<std::uint16_t>(level.children | 1 << child);
        }
        level.slack = remainder(set, level.half);
        if (number > 0) fill_level(set, split, level);
        split.levels.push_back(std::move(level));
    }
    fill_corners(set, split);
    return split;
}

}  // namespace rankdrop
