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

// At the centres of equal cells.
std::vector<Waves> along(double lower, double upper, int cells) {
    std::vector<Waves> found;
    const double width = (upper - lower) / cells;
    for (int i = 0; i < cells; ++i) found.push_back(waves(lower + (i + 0.5) * width));
    return found;
}

// The tables of one level, whose parents have half as many cells where `halved` is 1.
void fill_level(const SplitSettings& set, const Split& split, SplitLevel& level) {
    std::array<std::vector<Waves>, kSplitVariables> at;
    for (std::size_t j = 0; j < kSplitVariables; ++j) at[j] = along(split.lower[j], split.upper[j], level.cells[j]);
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

// Bernstein coefficients of each wave on a box of half-width h around x, over [-T, T] in t = tan(d / 2), T = tan(h / 2):
// a wave times (1 + t^2)^k is a polynomial of degree 2k; divided by its weight (1 + T^2)^k at the ends.
template <int Degree>
struct Shape {
    double at[Degree + 1][Degree + 1];  // [coefficient][wave]
};

void blossom(const double (&c)[3], double t, double (&out)[3]) {
    const double weight = 1.0 + t * t;
    out[0] = (c[0] - c[1] * t + c[2] * t * t) / weight;
    out[1] = (c[0] - c[2] * t * t) / weight;
    out[2] = (c[0] + c[1] * t + c[2] * t * t) / weight;
}

void blossom(const double (&c)[5], double t, double (&out)[5]) {
    const double weight = (1.0 + t * t) * (1.0 + t * t);
    const double c1 = c[1] * t, c2 = c[2] * t * t, c3 = c[3] * t * t * t, c4 = c[4] * t * t * t * t;
    out[0] = (c[0] - c1 + c2 - c3 + c4) / weight;
    out[1] = (c[0] - 0.5 * c1 + 0.5 * c3 - c4) / weight;
    out[2] = (c[0] - c2 / 3.0 + c4) / weight;
    out[3] = (c[0] + 0.5 * c1 - 0.5 * c3 - c4) / weight;
    out[4] = (c[0] + c1 + c2 + c3 + c4) / weight;
}

Shape<2> outer_shape(const Waves& centre, double t) {
    const double c = centre.value[1], s = centre.value[2];
    const double powers[3][3] = {{1, 0, 1}, {c, -2 * s, -c}, {s, 2 * c, -s}};  // 1, cos, sin times 1 + t^2
    Shape<2> out;
    for (int wave = 0; wave < 3; ++wave) {
        double found[3];
        blossom(powers[wave], t, found);
        for (int k = 0; k < 3; ++k) out.at[k][wave] = found[k];
    }
    return out;
}

Shape<4> inner_shape(const Waves& centre, double t) {
    const double c = centre.value[1], s = centre.value[2], c2 = centre.value[3], s2 = centre.value[4];
    // times (1 + t^2)^2; with cos(x + d) = c cos d - s sin d, cos 2d (1 + t^2)^2 = 1 - 6 t^2 + t^4, sin 2d … = 4 t - 4 t^3
    const double powers[5][5] = {{1, 0, 2, 0, 1},
                                 {c, -2 * s, 0, -2 * s, -c},
                                 {s, 2 * c, 0, 2 * c, -s},
                                 {c2, -4 * s2, -6 * c2, 4 * s2, c2},
                                 {s2, 4 * c2, -6 * s2, -4 * c2, s2}};
    Shape<4> out;
    for (int wave = 0; wave < 5; ++wave) {
        double found[5];
        blossom(powers[wave], t, found);
        for (int k = 0; k < 5; ++k) out.at[k][wave] = found[k];
    }
    return out;
}

// The fifteen Bernstein coefficients of one minor, those of the inner variable side by side.
void shape_of(const double* coefficients, const Shape<2>& outer, const Shape<4>& inner, double* out) {
    for (int i = 0; i < kOuter; ++i) {
        double row[kInner];
        for (int wave = 0; wave < kInner; ++wave) {
            row[wave] = 0.0;
            for (int k = 0; k < kOuter; ++k) row[wave] += outer.at[i][k] * coefficients[k * kInner + wave];
        }
        for (int j = 0; j < kInner; ++j) {
            double total = 0.0;
            for (int wave = 0; wave < kInner; ++wave) total += inner.at[j][wave] * row[wave];
            out[i * kInner + j] = total;
        }
    }
}

template <class Made, class Make>
std::vector<Made> shapes(const Split& split, const SplitLevel& level, std::size_t j, Make make) {
    baseline::Pack sine, cosine;
    baseline::sincos(baseline::fill(level.half[j]), sine, cosine);
    const double t = baseline::get(sine, 0) / (1.0 + baseline::get(cosine, 0)) * (1.0 + 1e-15);  // tan(h / 2)
    std::vector<Made> found;
    for (const Waves& centre : along(split.lower[j], split.upper[j], level.cells[j])) found.push_back(make(centre, t));
    return found;
}

void fill_shapes(const SplitSettings& set, const Split& split, SplitLevel& level) {
    const auto q2 = shapes<Shape<2>>(split, level, 0, outer_shape);
    const auto q3 = shapes<Shape<4>>(split, level, 1, inner_shape);
    const auto q4 = shapes<Shape<4>>(split, level, 2, inner_shape);
    const auto q5 = shapes<Shape<2>>(split, level, 3, outer_shape);
    double found[kWaves];
    level.shape_a.resize(q2.size() * q3.size() * kWaves * kMinors);
    double* a = level.shape_a.data();
    for (const Shape<2>& outer : q2)
        for (const Shape<4>& inner : q3) {
            for (int t = 0; t < kMinors; ++t) {
                shape_of(set.a + t * kWaves, outer, inner, found);
                for (int k = 0; k < kWaves; ++k) a[k * kMinors + t] = found[k];
            }
            a += kWaves * kMinors;
        }
    level.shape_b.resize(q4.size() * q5.size() * kMinors * kRow);
    double* b = level.shape_b.data();
    for (const Shape<4>& inner : q4)
        for (const Shape<2>& outer : q5)
            for (int t = 0; t < kMinors; ++t) {
                shape_of(set.b + t * kWaves, outer, inner, b);
                b[kWaves] = b[kWaves - 1];
                b += kRow;
            }
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
    split.further = set.further;
    split.rounding = set.rounding;
    for (int number = 0; number <= split.depths; ++number) {
        SplitLevel level;
        for (std::size_t j = 0; j < kSplitVariables; ++j) {
            level.cells[j] = 1 << std::min(number, set.depth[j]);
            level.halved[j] = number > 0 && number <= set.depth[j];
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
        if (number > 0) {
            fill_level(set, split, level);
            fill_shapes(set, split, level);
        }
        split.levels.push_back(std::move(level));
    }
    return split;
}

}  // namespace rankdrop
