// A pack of points beside the singular set: how far sigma is from zero, the way back to the set, and the part of the way to
// the centre that lies along it.
#pragma once

#include <algorithm>

#include "block.hpp"
#include "settings.hpp"

namespace rankdrop::RANKDROP_ISA {

// Everything is measured in x = (q - centre) / scale.
class Tangent {
  public:
    Tangent(const Chain& chain, const View& view, const NearestSettings& settings, Arena& arena)
        : chain_(chain), view_(view), set_(settings), n_(chain.variables),
          entries_((view.m - settings.rank) * (n_ - settings.rank)),
          values_(entries_ < n_ ? entries_ : n_), ws_(chain, view.m, arena), block_(chain, view.m, settings.rank, arena) {
        const std::size_t n = static_cast<std::size_t>(n_), entries = static_cast<std::size_t>(entries_);
        for (Pack** vector : {&correction, &tangent, &q_, &slope_, &free_}) *vector = arena.take<Pack>(n);
        w_ = arena.take<Pack>(entries * n), basis_ = arena.take<Pack>(n * n);
        size_ = arena.take<Pack>(std::max(entries, n));
    }

    Pack *correction, *tangent;  // to the set; along it, towards the centre
    Pack smallest;               // singular value of A = D in scaled variables that is not zero
    Pack sigma() const { return ws_.sigma[set_.rank]; }

    // At x, which is moved inside the limits: singular values, Gauss-Newton correction -A^+ F, and the part of -x along the set
    void evaluate(Pack* x) {
        for (int j = 0; j < n_; ++j) {
            q_[j] = fill(set_.centre[j]) + x[j] * fill(scale(j));
            if (set_.lower.empty()) continue;
            q_[j] = min(max(q_[j], fill(set_.lower[j])), fill(set_.upper[j]));
            x[j] = (q_[j] - fill(set_.centre[j])) / fill(scale(j));
        }
        decompose_fast(chain_, view_, q_, set_.rank, ws_);
        fill_block(chain_, view_, set_.rank, ws_, block_);
        for (int j = 0; j < n_; ++j) free_[j] = fill(1.0);
        for (int e = 0; e < entries_; ++e)
            for (int j = 0; j < n_; ++j) block_.d[e * n_ + j] = block_.d[e * n_ + j] * scale(j);
        split(x);
        if (set_.lower.empty()) return;
        for (int pass = 0; pass < n_ && hold_at_limits(); ++pass) split(x);
    }

    // The part of a lane's vector in the tangent space of the last evaluation, over joints that are not held
    void project(int lane, double* vector) const {
        for (int j = 0; j < n_; ++j) vector[j] = vector[j] * get(free_[j], lane);
        for (int i = 0; i < values_; ++i) {
            const Pack* v = (entries_ > n_ ? basis_ : w_) + i * n_;
            double overlap = 0.0;
            for (int j = 0; j < n_; ++j) overlap = overlap + get(v[j], lane) * vector[j];
            for (int j = 0; j < n_; ++j) vector[j] = vector[j] - overlap * get(v[j], lane);
        }
    }

  private:
    // Right singular vectors of A = D in scaled variables; those with a value above a cut span what F sees, the rest the
    // tangent space. Joints that are held count as if they were not there. Values that are zero on the set are of the
    // order of sigma beside it, those of a double piece of the order of its root: the cut lies between the two.
    void split(const Pack* x) {
        const bool tall = entries_ > n_;
        for (int e = 0; e < entries_; ++e)
            for (int j = 0; j < n_; ++j) w_[tall ? j * entries_ + e : e * n_ + j] = block_.d[e * n_ + j] * free_[j];
        for (int j = 0; j < n_; ++j) {
            slope_[j] = fill(0.0);
            for (int e = 0; e < entries_; ++e) slope_[j] = slope_[j] + block_.d[e * n_ + j] * block_.f[e];
            slope_[j] = slope_[j] * free_[j];
            correction[j] = fill(0.0);
            tangent[j] = -x[j] * free_[j];
        }
        svd(w_, tall ? entries_ : n_, values_, kExact, size_, tall ? basis_ : nullptr);
        const Pack one = fill(1.0), zero = fill(0.0);
        const Pack cut = fill(kCut) * sqrt(max(ws_.sigma[set_.rank], fill(1e-16)));
        smallest = size_[0];
        for (int i = 0; i < values_; ++i) {
            const Mask seen = size_[i] > cut;
            smallest = select(seen, size_[i], smallest);
            const Pack inverse = one / max(size_[i], cut);
            const Pack norm = tall ? one : inverse;
            Pack* v = tall ? basis_ + i * n_ : w_ + i * n_;
            Pack pull = zero, way = zero;
            for (int j = 0; j < n_; ++j) {
                v[j] = select(seen, v[j] * norm, zero);
                pull = pull + v[j] * slope_[j];
                way = way + v[j] * tangent[j];
            }
            pull = pull * inverse * inverse;
            for (int j = 0; j < n_; ++j) {
                correction[j] = correction[j] - pull * v[j];
                tangent[j] = tangent[j] - way * v[j];
            }
        }
    }

    // Holds joints at a limit that would be pushed across it; true where one was added
    bool hold_at_limits() {
        const Pack zero = fill(0.0);
        const Mask on_set = ws_.sigma[set_.rank] <= fill(set_.target);
        bool added = false;
        for (int j = 0; j < n_; ++j) {
            const Pack push = select(on_set, tangent[j], correction[j]);
            const Mask held = ((q_[j] <= fill(set_.lower[j])) & (push < zero)) |
                              ((q_[j] >= fill(set_.upper[j])) & (push > zero));
            if (!any(held)) continue;
            added = true;
            free_[j] = select(held, zero, free_[j]);
        }
        return added;
    }

    double scale(int j) const { return set_.scale[j]; }

    static constexpr double kCut = 1e-2;  // values of D below this times the root of sigma are zero

    const Chain& chain_;
    const View& view_;
    const NearestSettings& set_;
    const int n_, entries_, values_;
    Workspace ws_;
    Block block_;
    Pack *q_, *slope_, *free_, *w_, *basis_, *size_;
};

}  // namespace rankdrop::RANKDROP_ISA
