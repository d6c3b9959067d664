// Ball: the largest ball around q0 that is proven free of singularities, by branch and bound with enclosures.
//
// Boxes that may still hold a singularity wait in a heap, the nearest to q0 first; the distance of the nearest one is
// certified at any time. A box is dropped when its enclosure keeps the rank, when it lies outside the ball asked for, or
// inside a smaller ball that is known to be free.
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
        push(fresh(root()));
        BallResult out;
        const std::int64_t batch = 8;  // whatever the width of the lanes: the order of the boxes is the same everywhere
        std::vector<double> q(batch * n_), half(batch * n_);
        std::vector<std::int8_t> free(batch);
        std::vector<std::int32_t> split(batch);
        while (!heap_.empty() && out.evaluations < ball_.budget) {
            taken_.clear();
            while (!heap_.empty() && (std::int64_t)taken_.size() < std::min(batch, ball_.budget - out.evaluations)) taken_.push_back(pop());
            if (out.evaluations > 0 && widest(half_of(taken_.front())) < ball_.smallest) {  // the singular set is here, or too near to tell
                for (const Box& box : taken_) put(box);
                break;
            }
            for (std::size_t b = 0; b < taken_.size(); ++b)
                for (int i = 0; i < n_; ++i) {
                    const double centre = q0_[i] + centre_of(taken_[b])[i] * set_.scale[i], wide = half_of(taken_[b])[i];
                    const double rounded = 1e-15 * (1.0 + std::fabs(centre) / set_.scale[i]);  // of centre and corners
                    q[b * n_ + i] = centre;
                    half[b * n_ + i] = wide > 0.0 ? wide * (1.0 + 1e-12) + rounded : 0.0;
                }
            EnclosureOutput found;
            found.free = free.data(), found.split = split.data();
            kernels().enclose(chain_, view_, set_, q.data(), half.data(), 0, (std::int64_t)taken_.size(), found);
            out.evaluations += (std::int64_t)taken_.size();
            for (std::size_t b = 0; b < taken_.size(); ++b) {
                if (!free[b]) {
                    divide(taken_[b], split[b]);
                    continue;
                }
                if (ball_.keep) {
                    out.centre.insert(out.centre.end(), centre_of(taken_[b]), centre_of(taken_[b]) + n_);
                    out.half.insert(out.half.end(), half_of(taken_[b]), half_of(taken_[b]) + n_);
                }
                unused_.push_back(taken_[b].place);
            }
            if (++rounds_ % 256 == 0 && poll()) {
                out.stopped = true;
                break;
            }
        }
        out.radius = heap_.empty() ? radius_ : std::max(ball_.inner, std::min(radius_, heap_.front().distance));
        return out;
    }

  private:
    struct Box {
        double distance;    // of its nearest point to q0
        std::size_t place;  // of its centre and half-widths in the pool
    };

    std::vector<double> root() const {
        std::vector<double> both(2 * n_, 0.0);
        for (int i = 0; i < n_; ++i) both[n_ + i] = matters_[i] ? radius_ : 0.0;
        return both;
    }

    // Scaled, relative to q0
    double* centre_of(const Box& box) { return pool_.data() + 2 * n_ * box.place; }
    double* half_of(const Box& box) { return centre_of(box) + n_; }

    static bool later(const Box& a, const Box& b) { return a.distance > b.distance; }

    double widest(const double* half) const { return *std::max_element(half, half + n_); }

    // A box with this centre and these half-widths, in a place that is free
    Box fresh(const std::vector<double>& both) {
        std::size_t place = pool_.size() / both.size();
        if (unused_.empty()) {
            pool_.insert(pool_.end(), both.begin(), both.end());
        } else {
            place = unused_.back();
            unused_.pop_back();
            std::copy(both.begin(), both.end(), pool_.begin() + (std::ptrdiff_t)(place * both.size()));
        }
        return {0.0, place};
    }

    // Into the heap, unless it lies outside the ball, or inside the smaller one
    void push(Box box) {
        const double *centre = centre_of(box), *half = half_of(box);
        double near = 0.0, far = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double gap = std::fmax(0.0, std::fabs(centre[i]) - half[i]), end = std::fabs(centre[i]) + half[i];
            near += gap * gap, far += end * end;
        }
        box.distance = std::fmax(0.0, std::sqrt(near) * (1.0 - 1e-14) - 1e-15);  // corners are rounded
        if (box.distance < radius_ && std::sqrt(far) * (1.0 + 1e-14) + 1e-15 > ball_.inner)
            put(box);
        else
            unused_.push_back(box.place);
    }

    void put(const Box& box) {
        heap_.push_back(box);
        std::push_heap(heap_.begin(), heap_.end(), later);
    }

    Box pop() {
        std::pop_heap(heap_.begin(), heap_.end(), later);
        const Box box = heap_.back();
        heap_.pop_back();
        return box;
    }

    // In two along the variable that contributes most to the bound; a variable that is much wider goes first.
    void divide(const Box& box, int variable) {
        double* half = half_of(box);
        int axis = variable;
        const double room = widest(half);
        if (!(half[axis] > 0.02 * room)) axis = (int)(std::max_element(half, half + n_) - half);
        both_.assign(centre_of(box), centre_of(box) + 2 * n_);
        unused_.push_back(box.place);
        const double centre = both_[axis], width = both_[n_ + axis];
        both_[n_ + axis] = width * 0.5;
        for (const double side : {-0.5, 0.5}) {
            both_[axis] = centre + side * width;
            push(fresh(both_));
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
