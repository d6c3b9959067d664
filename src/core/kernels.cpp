// The kernels over ranges, compiled once per instruction set.
#include "kernels.hpp"

#include <algorithm>
#include <cstring>

#include "cover.hpp"
#include "derivative.hpp"
#include "descent.hpp"
#include "enclosure.hpp"
#include "equations.hpp"
#include "foot.hpp"
#include "nearest.hpp"
#include "links.hpp"
#include "newton.hpp"
#include "set_feet.hpp"
#include "spread.hpp"
#include "svd_of_one.hpp"

namespace rankdrop::RANKDROP_ISA {
namespace {

Pack* take(Arena& arena, int count) { return arena.take<Pack>(static_cast<std::size_t>(count)); }

int lanes_left(std::int64_t row, std::int64_t end) { return end - row < W ? (int)(end - row) : W; }

// Matrix held by columns in lanes -> row-major rows x columns
void store_columns(const Pack* in, int rows, int columns, int count, double* out, std::ptrdiff_t stride,
                   Pack* room) {
    int i = 0, j = 0;
    const auto next = [&] {
        const Pack& entry = in[j * rows + i];
        if (++j == columns) j = 0, ++i;
        return entry;
    };
    store_each(next, rows * columns, count, out, stride, room);
}

void pose(const Chain& chain, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables;
    Arena arena;
    Placed at = placed_in(chain, arena);
    Pack* x = take(arena, n);
    const View view;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, at);
        for (int lane = 0; lane < count; ++lane) {
            double* t = out + (row + lane) * 16;
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) t[4 * i + j] = get(at.end.r[3 * i + j], lane);
                t[4 * i + 3] = get(at.end.t[i], lane);
                t[12 + i] = 0.0;
            }
            t[15] = 1.0;
        }
    }
}

void task_jacobian(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, m = view.m;
    Arena arena;
    Placed at = placed_in(chain, arena);
    Pack *x = take(arena, n), *columns = take(arena, m * n);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, at);
        jacobian(chain, view, at, columns, n, 1);
        store(columns, m * n, count, out + row * m * n, m * n);
    }
}

void derivative(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, size = view.m * n * n;
    Arena arena;
    Placed at = placed_in(chain, arena);
    Derivative slopes(chain, view, arena);
    Pack *x = take(arena, n), *slope = W == 1 ? nullptr : take(arena, size);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, at);
        if constexpr (W == 1) {
            slopes.at(at, reinterpret_cast<Pack*>(out + row * size));  // a lane is a number
            continue;
        }
        slopes.at(at, slope);
        store(slope, size, count, out + row * size, size);
    }
}

// The SVD of W matrices; with one lane the pairs of columns may have lanes instead.
void take_apart(Pack* w, int rows, int columns, Precision precision, Pack* sigma, Pack* basis) {
    if constexpr (W == 1)
        if (svd_of_one(reinterpret_cast<double*>(w), rows, columns, reinterpret_cast<double*>(sigma),
                       reinterpret_cast<double*>(basis)))
            return;
    svd(w, rows, columns, precision, sigma, basis);
}

void decompose_range(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end,
                     double* sigma, double* u, double* v) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n;
    Arena arena;
    Workspace ws(chain, m, arena);
    Pack *x = take(arena, n), *room = u ? take(arena, std::max(n, m) * std::max(n, m)) : nullptr;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, u ? s : -1, ws, take_apart);
        store(ws.sigma, s, count, sigma + row * s, s);
        if (!u) continue;
        store_columns(ws.u, m, m, count, u + row * m * m, m * m, room);
        store_columns(ws.v, n, n, count, v + row * n * n, n * n, room);
    }
}

void block_range(const Chain& chain, const View& view, int rank, const double* q, std::int64_t begin, std::int64_t end,
                 const BlockOutput& out) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n, p = m - rank, r = n - rank;
    Arena arena;
    Workspace ws(chain, m, arena);
    Block parts(chain, m, rank, arena);
    Pack *x = take(arena, n), *room = take(arena, std::max(n, m) * std::max(n, m));
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, rank, ws, take_apart);
        fill_block(chain, view, rank, ws, parts);
        store(ws.sigma, s, count, out.sigma + row * s, s);
        store(parts.f, p * r, count, out.f + row * p * r, p * r);
        store(parts.d, p * r * n, count, out.d + row * p * r * n, p * r * n);
        store_columns(ws.u + rank * m, m, p, count, out.u2 + row * m * p, m * p, room);
        store_columns(ws.v + rank * n, n, r, count, out.v2 + row * n * r, n * r, room);
    }
}

// Brings the largest entry of each matrix near 1 where it is so large or small that fourth powers would leave the range of
// doubles, by a power of two, which changes no digit; returns what the singular values are to be multiplied by.
Pack unit_of(Pack* a, int entries) {
    Pack most = fill(0.0), back = fill(1.0);
    for (int i = 0; i < entries; ++i) most = max(abs(a[i]), most);
    const Mask wild = (most > fill(1e50)) | ((most < fill(1e-50)) & (most > fill(0.0)));
    if (!any(wild)) return back;
    for (int lane = 0; lane < W; ++lane) {
        if (!get(wild, lane) || !std::isfinite(get(most, lane))) continue;
        const int exponent = std::ilogb(get(most, lane));
        for (int i = 0; i < entries; ++i) set(a[i], lane, std::scalbn(get(a[i], lane), -exponent));
        set(back, lane, std::scalbn(1.0, exponent));
    }
    return back;
}

void svd_range(int m, int n, const double* a, std::int64_t begin, std::int64_t end, double* sigma, double* u, double* v) {
    const int s = m < n ? m : n, longer = m < n ? n : m;
    Arena arena;
    Pack *given = take(arena, m * n), *w = take(arena, m * n), *sv = take(arena, s);
    Pack *narrow = u ? take(arena, s * s) : nullptr, *wide = u ? take(arena, longer * longer) : nullptr;
    Pack* room = u ? take(arena, longer * longer) : nullptr;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(a + row * m * n, m * n, count, m * n, given);
        const Pack unit = unit_of(given, m * n);
        if (m <= n)
            for (int i = 0; i < m * n; ++i) w[i] = given[i];
        else
            for (int i = 0; i < m; ++i)
                for (int j = 0; j < n; ++j) w[j * m + i] = given[i * n + j];
        svd(w, longer, s, kExact, sv, narrow);
        if (u) complete_basis(w, sv, longer, s, wide);
        for (int i = 0; i < s; ++i) sv[i] = sv[i] * unit;
        store(sv, s, count, sigma + row * s, s);
        if (!u) continue;
        store_columns(m <= n ? narrow : wide, m, m, count, u + row * m * m, m * m, room);
        store_columns(m <= n ? wide : narrow, n, n, count, v + row * n * n, n * n, room);
    }
}

void newton(const Chain& chain, const View& view, const SearchSettings& settings, const double* starts,
            std::int64_t begin, std::int64_t end, std::int64_t first, const SearchOutput& out,
            const std::atomic<bool>& stop) {
    Arena arena;
    BlockNewton(chain, view, settings, arena).run(starts, begin, end, first, out, stop);
}

void descend(const Chain& chain, const View& view, const SearchSettings& settings, const double* starts,
             std::int64_t begin, std::int64_t end, std::int64_t, const SearchOutput& out, const std::atomic<bool>& stop) {
    Arena arena;
    Descent(chain, view, settings, arena).run(starts, begin, end, out, stop);
}

void enclose(const Chain& chain, const View& view, const EnclosureSettings& settings, const double* q, const double* half,
             std::int64_t begin, std::int64_t end, const EnclosureOutput& out) {
    Arena arena;
    Enclosure(chain, view, settings, arena).run(q, half, begin, end, out);
}

void enclose_cut(const Chain& chain, const View& view, const EnclosureSettings& settings, const double* q, const double* half,
                 std::int64_t begin, std::int64_t end, const Cut& cut) {
    Arena arena;
    Enclosure(chain, view, settings, arena).run(q, half, begin, end, cut);
}

void nearest(const Chain& chain, const View& view, const NearestSettings& settings, const double* starts,
             std::int64_t begin, std::int64_t end, const NearestOutput& out, const std::atomic<bool>& stop) {
    Arena arena;
    NearestWalk(chain, view, settings, arena).run(starts, begin, end, out, stop);
}

void set_feet(const Chain& chain, const View& view, const SetFeetSettings& settings, double* q, std::int64_t count,
              std::int8_t* met, double* far) {
    Arena arena;
    SetFeet(chain, view, settings, arena).run(q, (int)count, met, far);
}

void links(const Chain& chain, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, count = chain.links();
    Arena arena;
    Pack *x = take(arena, n), *poses = take(arena, 12 * count);
    for (std::int64_t row = begin; row < end; row += W) {
        const int lanes = lanes_left(row, end);
        load(q + row * n, n, lanes, n, x);
        place_links(chain, x, poses);
        for (int lane = 0; lane < lanes; ++lane)
            for (int link = 0; link < count; ++link) {
                double* t = out + ((row + lane) * count + link) * 16;
                for (int i = 0; i < 3; ++i) {
                    for (int j = 0; j < 3; ++j) t[4 * i + j] = get(poses[12 * link + 3 * i + j], lane);
                    t[4 * i + 3] = get(poses[12 * link + 9 + i], lane);
                    t[12 + i] = 0.0;
                }
                t[15] = 1.0;
            }
    }
}

// Lanes of `regular`.
void far_of_regular(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings, int family,
                    const Pack* x, const Workspace& ws, Mask regular, int count, FarRoom& room, Apart<Pack>& out) {
    for (int lane = 0; lane < count; ++lane) {
        if (!get(regular, lane)) continue;
        const Apart<double> found = apart_by_set(chain, view, families, settings, family, x, ws, lane, room, nullptr);
        set(out.residual, lane, found.residual), set(out.distance, lane, found.distance);
    }
}

void monitor(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings,
             const double* q, std::int64_t begin, std::int64_t end, const SightingsOutput& out) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n;
    Arena arena;
    Workspace ws(chain, m, arena);
    Pack *x = take(arena, n), *gradient = take(arena, n), *scratch = take(arena, n * m);
    Pack* room = take(arena, std::max(n, m) * std::max(n, m));
    Pack *sine = take(arena, families.nodes()), *cosine = take(arena, families.nodes());
    Pack* phase = take(arena, 2 * families.phases());
    const Waves<Pack> waves{sine, cosine};
    const WalkRoom<Pack> walks(families, arena);
    FarRoom far(chain, m, families, arena);
    const bool lengthy = std::find(families.lengthy.begin(), families.lengthy.end(), 1) != families.lengthy.end();
    const int known = (int)families.corank.size();
    auto* each = arena.take<Apart<Pack>>((std::size_t)known);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, s, ws);
        Pack rank = fill(0.0);
        for (int i = 0; i < settings.generic; ++i)
            rank = rank + select(ws.sigma[i] > fill(settings.singular), fill(1.0), fill(0.0));
        const Mask regular = rank == fill((double)settings.generic), singular = rank < fill((double)settings.generic);
        const bool all = any(singular);
        waves_at(families, all, x, phase, sine, cosine);
        for (int family = 0; family < known; ++family) {
            const bool by_set = lengthy && families.lengthy[(std::size_t)family];
            each[family] = by_set && !all ? Apart<Pack>{} : apart<Pack>(families, family, x, waves, gradient, nullptr);
            if (by_set) far_of_regular(chain, view, families, settings, family, x, ws, regular, count, far, each[family]);
        }
        walk_all<Pack>(families, settings.start, x, walks, each, nullptr);
        const Pack lost = fill((double)settings.generic) - rank;
        const Attribution<Pack> met = attribute<Pack>(families, settings, lost, each);
        Pack distance = met.distance;
        if (settings.beyond)
            distance = min(distance, first_order_distance(chain, view, families, settings, ws, scratch, gradient));
        store(ws.sigma, s, count, out.sigma + row * s, s);
        store_columns(ws.u, m, m, count, out.u + row * m * m, m * m, room);
        if (out.v) store_columns(ws.v, n, n, count, out.v + row * n * n, n * n, room);
        for (int lane = 0; lane < count; ++lane) {
            out.rank[row + lane] = (std::int32_t)get(rank, lane);
            out.family[row + lane] = (std::int32_t)get(met.family, lane);
            out.nearest[row + lane] = (std::int32_t)get(met.nearest, lane);
            out.residual[row + lane] = get(met.residual, lane);
            out.distance[row + lane] = get(distance, lane);
        }
    }
}

void equations(const Families& table, const double* q, std::int64_t begin, std::int64_t end, double* f, double* slopes) {
    Arena arena;
    const int n = table.variables;
    Equations at(table, arena);
    const int e = at.count();
    Pack* x = take(arena, n);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        at.at(x);
        store(at.f, e, count, f + row * e, e);
        if (slopes) store(at.slopes, e * n, count, slopes + row * e * n, e * n);
    }
}

void zeros(const Families& table, const ZeroSettings& settings, double* q, std::int64_t begin, std::int64_t end, double* worst) {
    Arena arena;
    const int n = table.variables;
    ZeroFinder finder(table, settings, arena);
    Pack* x = take(arena, n);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        Pack left = finder.run(x);
        store(x, n, count, q + row * n, n);
        store(&left, 1, count, worst + row, 1);
    }
}

void feet(const Families& table, const FootSettings& settings, double* q, std::int64_t begin, std::int64_t end) {
    Arena arena;
    FootFinder(table, settings, arena).run(q + begin * table.variables, end - begin);
}

void cover(const Split& split, std::int64_t begin, std::int64_t end, CoverTree* out) {
    Cover work(split);
    for (std::int64_t number = begin; number < end; ++number) work.run(number, out[number - begin]);
}

void judge(const Split& split, const std::int32_t* leaves, int halvings, std::int64_t parts, std::int64_t begin,
           std::int64_t end, std::int8_t* out) {
    Cover work(split);
    for (std::int64_t row = begin; row < end; ++row) out[row] = work.judge(leaves + kSplitVariables * row, halvings, parts);
}

void shape(const Split& split, int level, const std::int32_t* place, double* out) { Cover(split).show(level, place, out); }

}  // namespace

extern const Kernels table;
#define RANKDROP_TEXT_(x) #x
#define RANKDROP_TEXT(x) RANKDROP_TEXT_(x)
const Kernels table{RANKDROP_TEXT(RANKDROP_ISA), W, pose, task_jacobian, derivative, decompose_range, block_range,
                    svd_range, newton, descend, enclose, enclose_cut, nearest, set_feet, links, monitor, spread, equations, zeros, feet, cover, judge, shape};

}  // namespace rankdrop::RANKDROP_ISA
