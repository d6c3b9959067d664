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
        push(std::vector<double>(n_, 0.0), root());
        BallResult out;
        const std::int64_t batch = 8;  // whatever the width of the lanes: the order of the boxes is the same everywhere
        std::vector<double> q(batch * n_), half(batch * n_);
        std::vector<std::int8_t> free(batch);
        std::vector<std::int32_t> split(batch);
        while (!heap_.empty() && out.evaluations < ball_.budget) {
            std::vector<Box> taken;
            while (!heap_.empty() && (std::int64_t)taken.size() < std::min(batch, ball_.budget - out.evaluations)) taken.push_back(pop());
            if (out.evaluations > 0 && widest(taken.front()) < ball_.smallest) {  // the singular set is here, or too near to tell
                for (Box& box : taken) put(std::move(box));
                break;
            }
            for (std::size_t b = 0; b < taken.size(); ++b)
                for (int i = 0; i < n_; ++i) {
                    const double centre = q0_[i] + taken[b].centre[i] * set_.scale[i], wide = taken[b].half[i];
                    const double rounded = 1e-15 * (1.0 + std::fabs(centre) / set_.scale[i]);  // of centre and corners
                    q[b * n_ + i] = centre;
                    half[b * n_ + i] = wide > 0.0 ? wide * (1.0 + 1e-12) + rounded : 0.0;
                }
            EnclosureOutput found;
            found.free = free.data(), found.split = split.data();
            kernels().enclose(chain_, view_, set_, q.data(), half.data(), 0, (std::int64_t)taken.size(), found);
            out.evaluations += (std::int64_t)taken.size();
            for (std::size_t b = 0; b < taken.size(); ++b) {
                if (!free[b]) {
                    divide(taken[b], split[b]);
                } else if (ball_.keep) {
                    out.centre.insert(out.centre.end(), taken[b].centre.begin(), taken[b].centre.end());
                    out.half.insert(out.half.end(), taken[b].half.begin(), taken[b].half.end());
                }
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
        std::vector<double> centre, half;  // scaled, relative to q0
        double distance;                   // of its nearest point to q0
    };

    std::vector<double> root() const {
        std::vector<double> half(n_);
        for (int i = 0; i < n_; ++i) half[i] = matters_[i] ? radius_ : 0.0;
        return half;
    }

    static bool later(const Box& a, const Box& b) { return a.distance > b.distance; }

    static double widest(const Box& box) { return *std::max_element(box.half.begin(), box.half.end()); }

    void push(std::vector<double> centre, std::vector<double> half) {
        double near = 0.0, far = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double gap = std::fmax(0.0, std::fabs(centre[i]) - half[i]), end = std::fabs(centre[i]) + half[i];
            near += gap * gap, far += end * end;
        }
        const double distance = std::fmax(0.0, std::sqrt(near) * (1.0 - 1e-14) - 1e-15);  // corners are rounded
        if (distance < radius_ && std::sqrt(far) * (1.0 + 1e-14) + 1e-15 > ball_.inner) put({std::move(centre), std::move(half), distance});
    }

    void put(Box box) {
        heap_.push_back(std::move(box));
        std::push_heap(heap_.begin(), heap_.end(), later);
    }

    Box pop() {
        std::pop_heap(heap_.begin(), heap_.end(), later);
        Box box = std::move(heap_.back());
        heap_.pop_back();
        return box;
    }

    // In two along the variable that contributes most to the bound; a variable that is much wider goes first.
    void divide(const Box& box, int variable) {
        int axis = variable;
        const double room = widest(box);
        if (!(box.half[axis] > 0.02 * room))
            axis = (int)(std::max_element(box.half.begin(), box.half.end()) - box.half.begin());
        for (const double side : {-0.5, 0.5}) {
            std::vector<double> centre = box.centre, half = box.half;
            centre[axis] += side * half[axis];
            half[axis] *= 0.5;
            push(std::move(centre), std::move(half));
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
    std::vector<Box> heap_;
};

}  // namespace rankdrop
