// Ball: the largest ball around q0 that is proven free of singularities, by branch and bound with enclosures.
//
// Every box knows a radius: its part in the ball of that radius around q0 is free. Boxes that may still hold a singularity
// wait in a heap, the least radius first, which is what is certified at any time. A box is looked at once, cut by the ball:
// as large a ball as its enclosure allows is its radius; it is divided when it is the least again, and its halves know what
// it knew. A box is dropped when its radius is the one asked for, when it lies outside that ball, or inside a smaller one
// that is known to be free.
//
// A box is looked at only as far as `kAhead` of the way from what is known to what is asked for: it is narrowed to that
// ball, in which its bounds are better, and looked at again when the others have come as far.
//
// Where the free boxes are kept they must be free as a whole: nothing is cut or narrowed then.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels.hpp"

namespace rankdrop {

struct BallResult {
    double radius = 0.0;            // certified, in scaled variables
    std::int64_t evaluations = 0;
    std::vector<double> centre, half;  // the boxes that were proven free, where they are kept (scaled, relative to q0)
    bool stopped = false;
};

class Ball {
  public:
    Ball(const Chain& chain, const View& view, const EnclosureSettings& settings, const double* q0, const bool* matters,
         const BallSettings& ball)
        : chain_(chain), view_(view), set_(settings), ball_(ball), n_(chain.variables), q0_(q0), matters_(matters),
          radius_(settings.radius) {}

    // `poll` is asked now and then whether to stop.
    template <class Poll>
    BallResult run(Poll poll) {
        root();
        BallResult out;
        const std::int64_t batch = 8;  // whatever the width of the lanes: the order of the boxes is the same everywhere
        Rows rows(batch, n_);
        bool small = false;
        while (!heap_.empty() && out.evaluations < ball_.budget && heap_.front().radius < ball_.enough) {
            taken_.clear();
            while (!heap_.empty() && !small && (std::int64_t)taken_.size() < std::min(batch, ball_.budget - out.evaluations)) {
                const Box box = pop();
                if (box.axis < 0) {
                    taken_.push_back(box);
                } else if (widest(half_of(box)) < ball_.smallest) {  // the singular set is here, or too near to tell
                    put(box);
                    small = true;
                } else {
                    divide(box);
                }
            }
            out.evaluations += (std::int64_t)taken_.size();
            look(rows);
            for (std::size_t b = 0; b < taken_.size(); ++b) judge(taken_[b], rows, b, out);
            if (small) break;
            if (++rounds_ % 256 == 0 && poll()) {
                out.stopped = true;
                break;
            }
        }
        out.radius = heap_.empty() ? radius_ : std::max(ball_.inner, std::min(radius_, heap_.front().radius));
        return out;
    }

  private:
    static constexpr double kAhead = 0.5;

    struct Box {
        double radius;      // its part in this ball is free
        std::size_t place;  // of its centre and half-widths in the pool
        int axis;           // along which it is to be divided; -1 before it is looked at
        double at;          // and where
    };

    // What a batch is looked at with, and what comes of it
    struct Rows {
        Rows(std::int64_t batch, int n)
            : q(batch * n), half(batch * n), offset(batch * n), rounding(batch), low(batch), high(batch), proven(batch),
              free(batch), split(batch) {}
        std::vector<double> q, half, offset, rounding, low, high, proven;
        std::vector<std::int8_t> free;
        std::vector<std::int32_t> split;
    };

    void root() {
        std::vector<double> both(2 * n_, 0.0);
        for (int i = 0; i < n_; ++i) both[n_ + i] = matters_[i] ? radius_ : 0.0;
        push(both.data(), ball_.inner);
    }

    // Scaled, relative to q0
    double* centre_of(const Box& box) { return pool_.data() + 2 * n_ * box.place; }
    double* half_of(const Box& box) { return centre_of(box) + n_; }

    // A type, so that the heap compares without a call
    struct Later {
        bool operator()(const Box& a, const Box& b) const { return a.radius > b.radius; }
    };

    double widest(const double* half) const { return *std::max_element(half, half + n_); }

    // Into the heap with the radius that is known, unless it lies outside the ball, or inside the smaller one
    void push(const double* both, double radius) {
        double near = 0.0, far = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double gap = std::max(0.0, std::fabs(both[i]) - both[n_ + i]), end = std::fabs(both[i]) + both[n_ + i];
            near += gap * gap, far += end * end;
        }
        const double distance = std::max(0.0, std::sqrt(near) * (1.0 - 1e-14) - 1e-15);  // corners are rounded
        if (distance >= radius_ || std::sqrt(far) * (1.0 + 1e-14) + 1e-15 <= ball_.inner) return;
        std::size_t place = pool_.size() / (2 * n_);
        if (unused_.empty()) {
            pool_.resize(pool_.size() + 2 * n_);
        } else {
            place = unused_.back();
            unused_.pop_back();
        }
        const Box box{std::max(radius, distance), place, -1, 0.0};
        std::copy(both, both + 2 * n_, centre_of(box));
        put(box);
    }

    void put(const Box& box) {
        heap_.push_back(box);
        std::push_heap(heap_.begin(), heap_.end(), Later{});
    }

    Box pop() {
        std::pop_heap(heap_.begin(), heap_.end(), Later{});
        const Box box = heap_.back();
        heap_.pop_back();
        return box;
    }

    // The smallest box around what a box and a ball around q0 have in common: offset and half of one row
    void narrow(double radius, double* offset, double* half) const {
        double near = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double gap = std::max(0.0, std::fabs(offset[i]) - half[i]);
            near += gap * gap;
        }
        for (int i = 0; i < n_; ++i) {
            const double gap = std::max(0.0, std::fabs(offset[i]) - half[i]);
            const double end = std::sqrt(std::max(0.0, radius * radius - (near - gap * gap))) * (1.0 + 1e-12) + 1e-14;
            const double low = std::max(offset[i] - half[i], -end), high = std::min(offset[i] + half[i], end);
            if (!(low < high)) continue;  // a variable that does not matter
            if (low > offset[i] - half[i] || high < offset[i] + half[i]) {
                offset[i] = 0.5 * (low + high);
                half[i] = std::max(high - offset[i], offset[i] - low) * (1.0 + 1e-15);
            }
        }
    }

    void look(Rows& rows) {
        const std::int64_t count = (std::int64_t)taken_.size();
        for (std::int64_t b = 0; b < count; ++b) {
            const Box& box = taken_[b];
            double *offset = rows.offset.data() + b * n_, *half = rows.half.data() + b * n_;
            std::copy(centre_of(box), centre_of(box) + n_, offset);
            std::copy(half_of(box), half_of(box) + n_, half);
            rows.low[b] = box.radius;
            rows.high[b] = std::min(radius_, box.radius + kAhead * radius_);
            if (!ball_.keep) narrow(rows.high[b], offset, half);
            rows.rounding[b] = 0.0;
            for (int i = 0; i < n_; ++i) {
                const double centre = q0_[i] + offset[i] * set_.scale[i];
                const double rounded = 1e-15 * (1.0 + std::fabs(centre) / set_.scale[i]);  // of centre and corners
                rows.q[b * n_ + i] = centre;
                rows.rounding[b] += rounded;
                half[i] = half[i] > 0.0 ? half[i] * (1.0 + 1e-12) + rounded : 0.0;
            }
        }
        if (ball_.keep) {
            EnclosureOutput found;
            found.free = rows.free.data(), found.split = rows.split.data();
            kernels().enclose(chain_, view_, set_, rows.q.data(), rows.half.data(), 0, count, found);
            for (std::int64_t b = 0; b < count; ++b) rows.proven[b] = rows.free[b] ? rows.high[b] = radius_ : rows.low[b];
            return;
        }
        const Cut cut{rows.offset.data(), rows.rounding.data(), rows.low.data(),
                      rows.high.data(),   rows.proven.data(),   rows.split.data()};
        kernels().enclose_cut(chain_, view_, set_, rows.q.data(), rows.half.data(), 0, count, cut);
    }

    void judge(Box box, const Rows& rows, std::size_t b, BallResult& out) {
        box.radius = rows.proven[b];
        if (box.radius >= radius_) {
            if (ball_.keep) {
                out.centre.insert(out.centre.end(), centre_of(box), centre_of(box) + n_);
                out.half.insert(out.half.end(), half_of(box), half_of(box) + n_);
            }
            unused_.push_back(box.place);
            return;
        }
        if (box.radius < rows.high[b]) choose(box, rows, b);
        put(box);
    }

    // In two along the variable that contributes most to the bound; a variable that is much wider goes first.
    void choose(Box& box, const Rows& rows, std::size_t b) {
        const double* half = rows.half.data() + b * n_;
        box.axis = rows.split[b];
        if (!(half[box.axis] > 0.02 * widest(half))) box.axis = (int)(std::max_element(half, half + n_) - half);
        box.at = rows.offset[b * n_ + box.axis];
    }

    void divide(const Box& box) {
        both_.assign(centre_of(box), centre_of(box) + 2 * n_);
        unused_.push_back(box.place);
        const double centre = both_[box.axis], half = both_[n_ + box.axis], low = centre - half, high = centre + half;
        const bool halves = box.at == centre;  // not a bit wider: a checker cuts at the same places
        for (const bool upper : {false, true}) {
            both_[box.axis] = halves ? centre + (upper ? 0.5 : -0.5) * half : 0.5 * (upper ? box.at + high : low + box.at);
            both_[n_ + box.axis] = halves ? 0.5 * half : 0.5 * (upper ? high - box.at : box.at - low) * (1.0 + 1e-15);
            push(both_.data(), box.radius);
        }
    }

    const Chain& chain_;
    const View& view_;
    const EnclosureSettings& set_;
    const BallSettings ball_;
    const int n_;
    const double* q0_;
    const bool* matters_;
    const double radius_;
    std::int64_t rounds_ = 0;
    std::vector<Box> heap_, taken_;
    std::vector<double> pool_, both_;  // of all boxes: centres and half-widths; of one
    std::vector<std::size_t> unused_;  // places in the pool
};

}  // namespace rankdrop
