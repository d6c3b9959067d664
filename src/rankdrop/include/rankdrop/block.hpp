// The block: U2 and V2 span the smallest singular directions, F = U2^T J V2 vanishes exactly where the rank drops to
// `rank`, and D = U2^T dJ V2 says what each joint does to it.
#pragma once

#include <algorithm>

#include "chain.hpp"
#include "memory.hpp"
#include "svd.hpp"

namespace rankdrop::RANKDROP_ISA {

// Scratch for one pack of configurations; taken once, used again for a whole range.
struct Workspace {
    Placed at;
    Pack *jacobian, *w, *sigma, *u, *v;
    Pack* before;  // the narrow side where `decompose_fast` was last, orthonormal

    Workspace(const Chain& chain, int m_, Arena& arena) : at(placed_in(chain, arena)) {
        const std::size_t m = static_cast<std::size_t>(m_), n = static_cast<std::size_t>(chain.variables);
        jacobian = arena.take<Pack>(m * n), w = arena.take<Pack>(m * n);
        sigma = arena.take<Pack>(std::min(m, n));
        u = arena.take<Pack>(m * m), v = arena.take<Pack>(n * n);
        before = arena.take<Pack>(std::min(m, n) * std::min(m, n));
    }
};

// F and D of one pack of configurations, and what they are made with.
struct Block {
    Pack *f, *d, *scratch;

    Block(const Chain& chain, int m, int rank, Arena& arena) {
        const std::size_t n = static_cast<std::size_t>(chain.variables);
        const std::size_t entries = static_cast<std::size_t>(m - rank) * static_cast<std::size_t>(chain.variables - rank);
        f = arena.take<Pack>(entries), d = arena.take<Pack>(entries * n);
        scratch = arena.take<Pack>(n * static_cast<std::size_t>(m));
    }
};

// The Jacobian (m x n, by rows) at q, and its longer side by columns in ws.w, ready for `svd`.
inline void place(const Chain& chain, const View& view, const Pack* q, Workspace& ws) {
    const int m = view.m, n = chain.variables;
    forward(chain, view, q, ws.at);
    jacobian(chain, view, ws.at, ws.jacobian, n, 1);
    if (m <= n)
        for (int i = 0; i < m * n; ++i) ws.w[i] = ws.jacobian[i];
    else
        for (int a = 0; a < m; ++a)
            for (int j = 0; j < n; ++j) ws.w[j * m + a] = ws.jacobian[a * n + j];
}

// Singular values at q; U and V by columns, the first `keep` columns of the longer side from J, the rest any completion.
// keep < 0: singular values only. `take_apart` is `svd`, or what does the same.
template <class TakeApart>
inline void decompose(const Chain& chain, const View& view, const Pack* q, int keep, Workspace& ws, TakeApart take_apart) {
    const int m = view.m, n = chain.variables;
    place(chain, view, q, ws);
    Pack *narrow = m <= n ? ws.u : ws.v, *wide = m <= n ? ws.v : ws.u;
    const int longer = m <= n ? n : m, shorter = m <= n ? m : n;
    take_apart(ws.w, longer, shorter, kExact, ws.sigma, keep < 0 ? nullptr : narrow);
    if (keep >= 0) complete_basis(ws.w, ws.sigma, longer, keep < shorter ? keep : shorter, wide);
}

inline void decompose(const Chain& chain, const View& view, const Pack* q, int keep, Workspace& ws) {
    decompose(chain, view, q, keep, ws, svd);
}

// Of a Jacobian by rows, J or its transpose as it maps the wide side to the narrow one: the left vectors of the first
// `rank` right ones, and any completion. M, N: rows of the task and variables, or 0 where only run time knows them.
template <int M, int N>
inline void image_basis(const Pack* jacobian, int m_, int n_, const Pack* sigma, const Pack* wide, int rank, Pack* narrow) {
    const int m = M ? M : m_, n = N ? N : n_, longer = m <= n ? n : m, shorter = m <= n ? m : n;
    const int row_step = m <= n ? n : 1, column_step = m <= n ? 1 : n;
    for (int i = 0; i < rank; ++i) {
        const Pack scale = fill(1.0) / max(sigma[i], fill(1e-300));
        for (int a = 0; a < shorter; ++a) {
            Pack sum = fill(0.0);
            for (int j = 0; j < longer; ++j)
                sum = sum + jacobian[a * row_step + j * column_step] * wide[i * longer + j];
            narrow[i * shorter + a] = sum * scale;
        }
    }
    for (int i = rank; i < shorter; ++i) append_orthogonal<(M < N ? M : N)>(narrow, shorter, i);
}

// Orthonormal columns from ones that are so but for what `kSearch` leaves; unit columns where some of them are noise.
template <int SIZE>
inline void orthonormal_again(const Pack* basis, int size_, Pack* out) {
    const int size = SIZE ? SIZE : size_;
    const Pack zero = fill(0.0), one = fill(1.0);
    Mask rotten = zero > zero;
    for (int i = 0; i < size; ++i) {
        Pack* x = out + i * size;
        for (int k = 0; k < size; ++k) x[k] = basis[i * size + k];
        for (int j = 0; j < i; ++j) {
            const Pack* y = out + j * size;
            Pack overlap = zero;
            for (int k = 0; k < size; ++k) overlap = overlap + x[k] * y[k];
            for (int k = 0; k < size; ++k) x[k] = x[k] - overlap * y[k];
        }
        Pack norm = zero;
        for (int k = 0; k < size; ++k) norm = norm + x[k] * x[k];
        const Mask long_enough = norm > fill(0.5);
        const Pack scale = one / sqrt(select(long_enough, norm, one));
        for (int k = 0; k < size; ++k) x[k] = x[k] * scale;
        rotten = rotten | (norm <= fill(0.5));
    }
    if (!any(rotten)) return;
    for (int i = 0; i < size; ++i)
        for (int k = 0; k < size; ++k) out[i * size + k] = select(rotten, i == k ? one : zero, out[i * size + k]);
}

// The longer side of a Jacobian by rows, by columns, in the basis of the narrow side.
template <int M, int N>
inline void seen_from(const Pack* jacobian, int m_, int n_, const Pack* narrow, Pack* w) {
    const int m = M ? M : m_, n = N ? N : n_, longer = m <= n ? n : m, shorter = m <= n ? m : n;
    const int row_step = m <= n ? n : 1, column_step = m <= n ? 1 : n;
    for (int i = 0; i < shorter; ++i)
        for (int j = 0; j < longer; ++j) {
            Pack sum = fill(0.0);
            for (int a = 0; a < shorter; ++a)
                sum = sum + jacobian[a * row_step + j * column_step] * narrow[i * shorter + a];
            w[i * longer + j] = sum;
        }
}

template <int M, int N>
inline void decompose_fast_of(const Chain& chain, const View& view, const Pack* q, int rank, Workspace& ws, const Mask* anew) {
    const int m = M ? M : view.m, n = N ? N : chain.variables, longer = m <= n ? n : m, shorter = m <= n ? m : n;
    place(chain, view, q, ws);
    Pack *narrow = m <= n ? ws.u : ws.v, *wide = m <= n ? ws.v : ws.u;
    if (anew) {
        if (any(*anew))
            for (int i = 0; i < shorter; ++i)
                for (int k = 0; k < shorter; ++k)
                    ws.before[i * shorter + k] = select(*anew, fill(i == k ? 1.0 : 0.0), ws.before[i * shorter + k]);
        seen_from<M, N>(ws.jacobian, m, n, ws.before, ws.w);
    }
    svd(ws.w, longer, shorter, kSearch, ws.sigma, nullptr);
    complete_basis(ws.w, ws.sigma, longer, rank, wide);
    image_basis<M, N>(ws.jacobian, m, n, ws.sigma, wide, rank, narrow);
    if (anew) orthonormal_again<(M < N ? M : N)>(narrow, shorter, ws.before);
}

// As `decompose` with keep = rank, for the search: the narrow side is not accumulated but taken as image of the wide one,
// and both are completed. The subspaces come out to kSearch, singular values to rounding, in little more than half the
// time. With `anew` the sweeps begin from the narrow side that this workspace holds of the configuration before, near
// which most are: a tenth of a search; the lanes that it names begin from none.
inline void decompose_fast(const Chain& chain, const View& view, const Pack* q, int rank, Workspace& ws,
                           const Mask* anew = nullptr) {
    if (view.m == 6 && chain.variables == 7) return decompose_fast_of<6, 7>(chain, view, q, rank, ws, anew);
    if (view.m == 6 && chain.variables == 6) return decompose_fast_of<6, 6>(chain, view, q, rank, ws, anew);
    decompose_fast_of<0, 0>(chain, view, q, rank, ws, anew);
}

// dJ(e_k) x for every variable k, with x in the space of the variables: out[k * m + a].
inline void derivative_times(const Chain& chain, const View& view, const Placed& at, const Pack* x, Pack* out) {
    const int n = chain.variables, joints = (int)chain.joints.size();
    for (int i = 0; i < n * view.m; ++i) out[i] = fill(0.0);
    Twist all{};
    for (int i = 0; i < 3; ++i) all.v[i] = all.w[i] = fill(0.0);
    Twist later = all;
    const auto add = [&](Twist& sum, int i) {
        const Pack value = x[chain.joints[i].variable];
        for (int c = 0; c < 3; ++c) {
            sum.v[c] = sum.v[c] + at.screws[i].v[c] * value;
            sum.w[c] = sum.w[c] + at.screws[i].w[c] * value;
        }
    };
    for (int i = 0; i < joints; ++i) add(all, i);
    Pack seen[6];
    for (int k = joints - 1; k >= 0; --k) {
        seen_derivative(view, at, k, later, all, seen);
        Pack* slot = out + chain.joints[k].variable * view.m;
        for (int a = 0; a < view.m; ++a) slot[a] = slot[a] + seen[view.row[a]] * view.factor[a];
        add(later, k);
    }
}

// M, N: rows of the task and variables, or 0 where only run time knows them.
template <int M, int N>
inline void fill_block_of(const Chain& chain, const View& view, int rank, const Workspace& ws, Block& out) {
    const int m = M ? M : view.m, n = N ? N : chain.variables, p = m - rank, r = n - rank;
    for (int b = 0; b < r; ++b) {
        const Pack* x = ws.v + (rank + b) * n;
        derivative_times(chain, view, ws.at, x, out.scratch);
        Pack image[6];
        for (int c = 0; c < m; ++c) {
            image[c] = fill(0.0);
            for (int j = 0; j < n; ++j) image[c] = image[c] + ws.jacobian[c * n + j] * x[j];
        }
        for (int a = 0; a < p; ++a) {
            const Pack* y = ws.u + (rank + a) * m;
            Pack sum = fill(0.0);
            for (int c = 0; c < m; ++c) sum = sum + y[c] * image[c];
            out.f[a * r + b] = sum;
            for (int k = 0; k < n; ++k) {
                Pack slope = fill(0.0);
                for (int c = 0; c < m; ++c) slope = slope + y[c] * out.scratch[k * m + c];
                out.d[(a * r + b) * n + k] = slope;
            }
        }
    }
}

// F[a * r + b] and D[(a * r + b) * n + k] at the configuration that `decompose(..., rank)` was called for.
inline void fill_block(const Chain& chain, const View& view, int rank, const Workspace& ws, Block& out) {
    if (view.m == 6 && chain.variables == 7) return fill_block_of<6, 7>(chain, view, rank, ws, out);
    if (view.m == 6 && chain.variables == 6) return fill_block_of<6, 6>(chain, view, rank, ws, out);
    return fill_block_of<0, 0>(chain, view, rank, ws, out);
}

}  // namespace rankdrop::RANKDROP_ISA
