// Cover: which boxes of (q2, q3, q4, q5) are free of zeros of f = a . b (split.hpp), by halving.
//
// A box with centre c and half-widths h is free where |f(c)| > sum |f_j(c)| h_j + slack: quick, and enough for most. Where it
// is not, f times a positive weight is a polynomial in the tangents of half angles, and free of zeros where its Bernstein
// coefficients have one sign; f itself stands at their corners, and where it has two signs there, there is a zero. Products
// of factors that are each of one sign keep one sign in all coefficients: that is what singular sets that cross need.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "split.hpp"

namespace rankdrop::RANKDROP_ISA {

class Cover {
  public:
    explicit Cover(const Split& split) : split_(split), allowed_(2.0 * split.rounding) {}

    // One box of the level `top`, by number in row-major order.
    void run(std::int64_t number, CoverTree& out) {
        out_ = &out;
        out.masks.assign(static_cast<std::size_t>(split_.depths - split_.top + 1), {});
        const SplitLevel& level = split_.levels[static_cast<std::size_t>(split_.top)];
        Cell cell;
        for (int j = 3; j >= 0; --j) {
            cell.at[j] = (int)(number % level.cells[(std::size_t)j]);
            number /= level.cells[(std::size_t)j];
        }
        visit(split_.top, cell);
    }

    // One leaf, by its place, halved so many times in so many parts: free (0), proven to hold a zero (1), or neither (2).
    std::int8_t judge(const std::int32_t* place, int halvings, std::int64_t parts) {
        const Cell cell{{place[0], place[1], place[2], place[3]}};
        Tensor x;
        Signs signs;
        Verdict told = fill(split_.depths, cell, x, signs);
        parts_ = parts;
        if (told == kOpen) told = look_into(x, halvings, 0, signs);
        return told;
    }

    // The Bernstein coefficients of one box (15, 16).
    void show(int level, const std::int32_t* place, double* out) const {
        const Cell cell{{place[0], place[1], place[2], place[3]}};
        Tensor x;
        for (auto& row : x.x)
            for (double& value : row) value = 0.0;
        const Place at = place_of(level, cell);
        for (int row = 0; row < kWaves; ++row) at.row(row, x);
        std::copy(&x.x[0][0], &x.x[0][0] + kWaves * kRow, out);
    }

  private:
    struct Cell {
        int at[4];
    };

    // Which of the 16 children of a box are not free by the series of first order.
    std::uint16_t test(int parent, const Cell& cell) {
        const SplitLevel& level = split_.levels[(std::size_t)parent + 1];
        const int p5 = level.cells[3] >> level.halved[3];
        const double* b = level.b.data() + ((std::ptrdiff_t)cell.at[2] * p5 + cell.at[3]) * 3 * kMinors * 4;
        unsigned open = 0;
        for (int pair = 0; pair < 4; ++pair) {
            if (((pair & 2) && !level.halved[0]) || ((pair & 1) && !level.halved[1])) continue;
            const std::ptrdiff_t x = (cell.at[0] << level.halved[0]) + (pair >> 1), y = (cell.at[1] << level.halved[1]) + (pair & 1);
            const double* a = level.a.data() + (x * level.cells[1] + y) * 3 * kMinors;
            double f[4] = {}, f2[4] = {}, f3[4] = {}, f4[4] = {}, f5[4] = {};
            for (int t = 0; t < kMinors; ++t)
                for (int lane = 0; lane < 4; ++lane) {
                    const double there = b[4 * t + lane];
                    f[lane] += a[t] * there;
                    f2[lane] += a[kMinors + t] * there;
                    f3[lane] += a[2 * kMinors + t] * there;
                    f4[lane] += a[t] * b[4 * (kMinors + t) + lane];
                    f5[lane] += a[t] * b[4 * (2 * kMinors + t) + lane];
                }
            for (int lane = 0; lane < 4; ++lane) {
                const double bound = std::fabs(f2[lane]) * level.half[0] + std::fabs(f3[lane]) * level.half[1] +
                                     std::fabs(f4[lane]) * level.half[2] + std::fabs(f5[lane]) * level.half[3] + level.slack;
                open |= (unsigned)!(std::fabs(f[lane]) > bound) << (4 * pair + lane);  // NaN is not free
            }
        }
        out_->tested += std::popcount((unsigned)level.children);
        return (std::uint16_t)(open & level.children);
    }

    Cell child_of(int parent, const Cell& cell, int child) const {
        const SplitLevel& level = split_.levels[(std::size_t)parent + 1];
        Cell out;
        for (int j = 0; j < 4; ++j) out.at[j] = (cell.at[j] << level.halved[(std::size_t)j]) + (child >> (3 - j) & 1);
        return out;
    }

    // Writes the masks of a box and of all below it; those that come out free altogether are taken back.
    std::uint16_t visit(int parent, const Cell& cell) {
        std::vector<std::uint16_t>& masks = out_->masks[(std::size_t)(parent - split_.top)];
        const std::size_t place = masks.size();
        unsigned open = test(parent, cell), proven = 0;
        const bool leaves = parent + 1 == split_.depths;
        if (!leaves) masks.push_back(0);
        for (unsigned rest = open; rest; rest &= rest - 1) {
            const int child = std::countr_zero(rest);
            const Cell below = child_of(parent, cell, child);
            Tensor x;
            Signs signs;
            Verdict told = fill(parent + 1, below, x, signs);
            if (leaves && told == kOpen) {
                parts_ = kMostParts;
                told = look_into(x, split_.further, 0, signs);
                out_->freed += told == kFree;
            }
            if (leaves && told == kBoth) proven |= 1u << child;
            if (told == kFree || (!leaves && !visit(parent + 1, below))) open &= ~(1u << child);
        }
        if (leaves) {
            if (open) {
                masks.push_back((std::uint16_t)open);
                out_->masks.back().push_back((std::uint16_t)proven);
            }
        } else if (open) {
            masks[place] = (std::uint16_t)open;
        } else {
            masks.pop_back();
        }
        return (std::uint16_t)open;
    }

    // f on a box by its Bernstein coefficients: rows by those of q2 and q3, columns by those of q4 and q5.
    struct Tensor {
        double x[kWaves][kRow];
    };
    enum Verdict : std::int8_t { kFree, kBoth, kOpen };  // one sign; two signs at corners; neither is told

    static constexpr int kCorners[4] = {0, 4, 10, 14};

    // The signs that f was seen to take, beyond rounding.
    struct Signs {
        bool plus = false, minus = false;
        bool both() const { return plus && minus; }
    };

    // f itself stands at the corners.
    void see_corners(const Tensor& t, Signs& signs) const {
        for (const int row : kCorners)
            for (const int column : kCorners) {
                signs.plus = signs.plus || t.x[row][column] > allowed_;
                signs.minus = signs.minus || t.x[row][column] < -allowed_;
            }
    }

    // f lies between the least and the largest coefficient, times a positive weight.
    bool free(const Tensor& t) const {
        double least[kRow], most[kRow];
        for (int k = 0; k < kRow; ++k) least[k] = most[k] = t.x[0][k];
        for (int row = 1; row < kWaves; ++row)
            for (int k = 0; k < kRow; ++k) {
                least[k] = t.x[row][k] < least[k] ? t.x[row][k] : least[k];
                most[k] = t.x[row][k] > most[k] ? t.x[row][k] : most[k];
            }
        double low = least[0], high = most[0];
        for (int k = 1; k < kRow; ++k) low = least[k] < low ? least[k] : low, high = most[k] > high ? most[k] : high;
        return low > allowed_ || high < -allowed_;
    }

    struct Place {
        const double *a, *b;
        void row(int row, Tensor& out) const {
            double* x = out.x[row];
            for (int k = 0; k < kRow; ++k) x[k] = a[row * kMinors] * b[k];
            for (int t = 1; t < kMinors; ++t)
                for (int k = 0; k < kRow; ++k) x[k] += a[row * kMinors + t] * b[t * kRow + k];
        }
    };

    Place place_of(int number, const Cell& cell) const {
        const SplitLevel& level = split_.levels[(std::size_t)number];
        return {level.shape_a.data() + ((std::ptrdiff_t)cell.at[0] * level.cells[1] + cell.at[1]) * kWaves * kMinors,
                level.shape_b.data() + ((std::ptrdiff_t)cell.at[2] * level.cells[3] + cell.at[3]) * kMinors * kRow};
    }

    // The coefficients of one box, of which only the corners where these have two signs.
    Verdict fill(int number, const Cell& cell, Tensor& out, Signs& signs) const {
        const Place at = place_of(number, cell);
        for (const int row : kCorners) at.row(row, out);
        see_corners(out, signs);
        if (signs.both()) return kBoth;
        for (int row = 0; row < kWaves; ++row)
            if (row != 0 && row != 4 && row != 10 && row != 14) at.row(row, out);
        return free(out) ? kFree : kOpen;
    }

    // Halves by the rule of de Casteljau: entries `step` apart, `degree + 1` of them.
    static void halve(const double* in, int step, int degree, double* low, double* high) {
        double x[5];
        for (int i = 0; i <= degree; ++i) x[i] = in[i * step];
        for (int i = 0; i <= degree; ++i) {
            low[i * step] = x[0], high[(degree - i) * step] = x[degree - i];
            for (int k = 0; k < degree - i; ++k) x[k] = 0.5 * (x[k] + x[k + 1]);
        }
    }

    static void halve(const Tensor& in, int variable, Tensor& low, Tensor& high) {
        const bool outer = variable == 0 || variable == 3, along_a = variable < 2;
        const int degree = outer ? 2 : 4;
        const int step = along_a ? (outer ? 5 * kRow : kRow) : (outer ? 5 : 1);
        for (int fixed = 0; fixed < (outer ? 5 : 3); ++fixed)       // the other variable of the same minor
            for (int k = 0; k < (along_a ? kRow : kWaves); ++k) {  // the other minor
                const int first = along_a ? (outer ? fixed : 5 * fixed) * kRow + k : k * kRow + (outer ? fixed : 5 * fixed);
                halve(&in.x[0][0] + first, step, degree, &low.x[0][0] + first, &high.x[0][0] + first);
            }
        if (!along_a)
            for (int row = 0; row < kWaves; ++row) low.x[row][kWaves] = low.x[row][0], high.x[row][kWaves] = high.x[row][0];
    }

    // Halved in turn along each variable, so many times, while parts are left: free all through, two signs somewhere, or not told.
    Verdict look_into(const Tensor& t, int halvings, int variable, Signs& signs) {
        if (halvings == 0 || (parts_ -= 2) < 0) return kOpen;
        Tensor parts[2];
        halve(t, variable, parts[0], parts[1]);
        bool left = false;
        for (const Tensor& part : parts) {
            see_corners(part, signs);
            if (signs.both()) return kBoth;
            if (free(part)) continue;
            const Verdict told = look_into(part, halvings - 1, (variable + 1) % kSplitVariables, signs);
            if (told == kBoth) return kBoth;
            left = left || told == kOpen;
        }
        return left ? kOpen : kFree;
    }

    const Split& split_;
    const double allowed_;  // twice the rounding: halving adds less than f itself has
    std::int64_t parts_ = 0;  // that a leaf may still be looked at in
    CoverTree* out_ = nullptr;
};

}  // namespace rankdrop::RANKDROP_ISA
