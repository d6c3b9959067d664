// Cover: which boxes of (q2, q3, q4, q5) are free of zeros of f = a . b (split.hpp), by halving.
//
// A box with centre c and half-widths h is free where |f(c)| > sum |f_j(c)| h_j + slack; a leaf is proven to hold a zero
// where f has two signs in it, beyond rounding, at corners or at centres of boxes inside.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "split.hpp"

namespace rankdrop::RANKDROP_ISA {

class Cover {
  public:
    explicit Cover(const Split& split) : split_(split) {}

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

    // One leaf, by its place: free (0), proven to hold a zero (1), or neither (2).
    std::int8_t judge(const std::int32_t* place, CoverTree& out) {
        out_ = &out;
        const Cell cell{{place[0], place[1], place[2], place[3]}};
        Signs signs;
        corners(cell, signs);
        const bool left = signs.both() || (int)split_.levels.size() == split_.depths + 1 || look_into(split_.depths, cell, signs);
        return signs.both() ? 1 : left ? 2 : 0;
    }

  private:
    struct Cell {
        int at[4];
    };

    // Which of the 16 children of a box of `level` are not free, and f at their centres.
    std::uint16_t test(int parent, const Cell& cell, double* values) {
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
                values[4 * pair + lane] = f[lane];
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
        double values[kFamilySize];
        std::vector<std::uint16_t>& masks = out_->masks[(std::size_t)(parent - split_.top)];
        const std::size_t place = masks.size();
        unsigned open = test(parent, cell, values), proven = 0;
        const bool leaves = parent + 1 == split_.depths;
        if (!leaves) masks.push_back(0);
        for (unsigned rest = open; rest; rest &= rest - 1) {
            const int child = std::countr_zero(rest);
            const Cell below = child_of(parent, cell, child);
            if (!leaves) {
                if (!visit(parent + 1, below)) open &= ~(1u << child);
                continue;
            }
            Signs signs;
            signs.see(values[child], split_.rounding);
            corners(below, signs);
            const bool further = !signs.both() && (int)split_.levels.size() > split_.depths + 1;
            if (further && !look_into(split_.depths, below, signs) && !signs.both()) {
                open &= ~(1u << child);
                ++out_->freed;
            }
            if (signs.both()) proven |= 1u << child;
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

    struct Signs {
        bool plus = false, minus = false;
        void see(double value, double rounding) { plus = plus || value > rounding, minus = minus || value < -rounding; }
        bool both() const { return plus && minus; }
    };

    void corners(const Cell& leaf, Signs& signs) const {
        const SplitLevel& level = split_.levels[(std::size_t)split_.depths];
        const double* b = split_.corners_b.data() + ((std::ptrdiff_t)leaf.at[2] * level.cells[3] + leaf.at[3]) * kMinors * 4;
        for (int pair = 0; pair < 4 && !signs.both(); ++pair) {
            const double* a = split_.corners_a.data() +
                              ((std::ptrdiff_t)(leaf.at[0] + (pair >> 1)) * (level.cells[1] + 1) + leaf.at[1] + (pair & 1)) * kMinors;
            double f[4] = {};
            for (int t = 0; t < kMinors; ++t)
                for (int lane = 0; lane < 4; ++lane) f[lane] += a[t] * b[4 * t + lane];
            for (int lane = 0; lane < 4; ++lane) signs.see(f[lane], split_.rounding);
        }
    }

    // Whether anything in a box of `parent` is left that is not free; stops where both signs were seen.
    bool look_into(int parent, const Cell& cell, Signs& signs) {
        double values[kFamilySize];
        const unsigned open = test(parent, cell, values);
        const SplitLevel& level = split_.levels[(std::size_t)parent + 1];
        for (int child = 0; child < kFamilySize; ++child)
            if (level.children >> child & 1) signs.see(values[child], split_.rounding);
        if (signs.both() || parent + 2 == (int)split_.levels.size()) return open != 0;
        bool left = false;
        for (unsigned rest = open; rest && !signs.both(); rest &= rest - 1)
            left = look_into(parent + 1, child_of(parent, cell, std::countr_zero(rest)), signs) || left;
        return left;
    }

    const Split& split_;
    CoverTree* out_ = nullptr;
};

}  // namespace rankdrop::RANKDROP_ISA
