// The kernels over ranges, compiled once per instruction set.
#include "kernels.hpp"

#include <cstdlib>
#include <cstring>

#include "descent.hpp"
#include "enclosure.hpp"
#include "nearest.hpp"
#include "links.hpp"
#include "monitor.hpp"
#include "newton.hpp"

namespace rankdrop::RANKDROP_ISA {
namespace {

// Aligned scratch for one call.
class Memory {
  public:
    explicit Memory(std::size_t packs) {
#if defined(_MSC_VER)
        base_ = _aligned_malloc((packs + 1) * sizeof(Pack), 64);
#else
        base_ = std::aligned_alloc(64, ((packs + 1) * sizeof(Pack) + 63) / 64 * 64);
#endif
        if (!base_) std::abort();
    }
    ~Memory() {
#if defined(_MSC_VER)
        _aligned_free(base_);
#else
        std::free(base_);
#endif
    }
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    Pack* packs() const { return static_cast<Pack*>(base_); }

  private:
    void* base_;
};

int lanes_left(std::int64_t row, std::int64_t end) { return end - row < W ? (int)(end - row) : W; }

// Matrix held by columns in lanes -> row-major rows x columns
void store_columns(const Pack* in, int rows, int columns, int count, double* out, std::ptrdiff_t stride) {
    for (int lane = 0; lane < count; ++lane)
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) out[stride * lane + i * columns + j] = get(in[j * rows + i], lane);
}

void pose(const Chain& chain, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables;
    Memory memory(Workspace::size(chain, 6) + n);
    Workspace ws(chain, 6, memory.packs());
    Pack* x = memory.packs() + Workspace::size(chain, 6);
    const View view;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, ws.at);
        for (int lane = 0; lane < count; ++lane) {
            double* t = out + (row + lane) * 16;
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) t[4 * i + j] = get(ws.at.end.r[3 * i + j], lane);
                t[4 * i + 3] = get(ws.at.end.t[i], lane);
                t[12 + i] = 0.0;
            }
            t[15] = 1.0;
        }
    }
}

void task_jacobian(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, m = view.m;
    Memory memory(Workspace::size(chain, m) + n);
    Workspace ws(chain, m, memory.packs());
    Pack* x = memory.packs() + Workspace::size(chain, m);
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, ws.at);
        jacobian(chain, view, ws.at, ws.jacobian, n, 1);
        store(ws.jacobian, m * n, count, out + row * m * n, m * n);
    }
}

void derivative(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, m = view.m;
    const std::size_t size = Workspace::size(chain, m);
    Memory memory(size + 2 * n + (std::size_t)n * m);
    Workspace ws(chain, m, memory.packs());
    Pack *x = memory.packs() + size, *unit = x + n, *slopes = unit + n;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        forward(chain, view, x, ws.at);
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) unit[j] = fill(i == j ? 1.0 : 0.0);
            derivative_times(chain, view, ws.at, unit, slopes);
            for (int lane = 0; lane < count; ++lane)
                for (int a = 0; a < m; ++a)
                    for (int k = 0; k < n; ++k)
                        out[(((row + lane) * m + a) * n + i) * n + k] = get(slopes[k * m + a], lane);
        }
    }
}

void decompose_range(const Chain& chain, const View& view, const double* q, std::int64_t begin, std::int64_t end,
                     double* sigma, double* u, double* v) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n;
    const std::size_t size = Workspace::size(chain, m);
    Memory memory(size + n);
    Workspace ws(chain, m, memory.packs());
    Pack* x = memory.packs() + size;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, u ? s : -1, ws);
        store(ws.sigma, s, count, sigma + row * s, s);
        if (!u) continue;
        store_columns(ws.u, m, m, count, u + row * m * m, m * m);
        store_columns(ws.v, n, n, count, v + row * n * n, n * n);
    }
}

void block_range(const Chain& chain, const View& view, int rank, const double* q, std::int64_t begin, std::int64_t end,
                 double* sigma, double* f, double* d, double* u2, double* v2) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n, p = m - rank, r = n - rank;
    const std::size_t size = Workspace::size(chain, m);
    Memory memory(size + n + (std::size_t)n * m);
    Workspace ws(chain, m, memory.packs());
    Pack *x = memory.packs() + size, *scratch = x + n;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, rank, ws);
        block(chain, view, rank, ws, scratch);
        store(ws.sigma, s, count, sigma + row * s, s);
        store(ws.f, p * r, count, f + row * p * r, p * r);
        store(ws.d, p * r * n, count, d + row * p * r * n, p * r * n);
        store_columns(ws.u + rank * m, m, p, count, u2 + row * m * p, m * p);
        store_columns(ws.v + rank * n, n, r, count, v2 + row * n * r, n * r);
    }
}

void svd_range(int m, int n, const double* a, std::int64_t begin, std::int64_t end, double* sigma, double* u, double* v) {
    const int s = m < n ? m : n, longer = m < n ? n : m;
    Memory memory(2 * (std::size_t)m * n + s + s * s + longer * longer);
    Pack *given = memory.packs(), *w = given + m * n, *sv = w + m * n, *narrow = sv + s, *wide = narrow + s * s;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(a + row * m * n, m * n, count, m * n, given);
        if (m <= n)
            std::memcpy(static_cast<void*>(w), given, sizeof(Pack) * m * n);
        else
            for (int i = 0; i < m; ++i)
                for (int j = 0; j < n; ++j) w[j * m + i] = given[i * n + j];
        svd(w, longer, s, kExact, sv, u ? narrow : nullptr);
        store(sv, s, count, sigma + row * s, s);
        if (!u) continue;
        complete_basis(w, sv, longer, s, wide);
        store_columns(m <= n ? narrow : wide, m, m, count, u + row * m * m, m * m);
        store_columns(m <= n ? wide : narrow, n, n, count, v + row * n * n, n * n);
    }
}

void newton(const Chain& chain, const View& view, const SearchSettings& settings, const double* starts,
            std::int64_t begin, std::int64_t end, std::int64_t first, const SearchOutput& out, const volatile bool* stop) {
    Memory memory(BlockNewton::size(chain, view.m));
    BlockNewton(chain, view, settings, memory.packs()).run(starts, begin, end, first, out, stop);
}

void descend(const Chain& chain, const View& view, const SearchSettings& settings, const double* starts,
             std::int64_t begin, std::int64_t end, std::int64_t, const SearchOutput& out, const volatile bool* stop) {
    Memory memory(Descent::size(chain, view.m));
    Memory numbers(Descent::doubles(chain, view.m) / W + 1);
    Descent(chain, view, settings, memory.packs(), reinterpret_cast<double*>(numbers.packs())).run(starts, begin, end, out, stop);
}

void enclose(const Chain& chain, const View& view, const EnclosureSettings& settings, const double* q, const double* half,
             std::int64_t begin, std::int64_t end, const EnclosureOutput& out) {
    Memory memory(Enclosure::size(chain, view.m));
    Enclosure(chain, view, settings, memory.packs()).run(q, half, begin, end, out);
}

void nearest(const Chain& chain, const View& view, const NearestSettings& settings, const double* starts,
             std::int64_t begin, std::int64_t end, const NearestOutput& out, const volatile bool* stop) {
    Memory memory(NearestWalk::size(chain, view.m, settings.rank));
    Memory numbers(NearestWalk::doubles(chain) / W + 1);
    NearestWalk(chain, view, settings, memory.packs(), reinterpret_cast<double*>(numbers.packs())).run(starts, begin, end, out, stop);
}

void links(const Chain& chain, const double* q, std::int64_t begin, std::int64_t end, double* out) {
    const int n = chain.variables, count = (int)chain.joints.size() + 2;
    Memory memory(n + 12 * (std::size_t)count);
    Pack *x = memory.packs(), *poses = x + n;
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

void monitor(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings,
             const double* q, std::int64_t begin, std::int64_t end, const SightingsOutput& out) {
    const int n = chain.variables, m = view.m, s = m < n ? m : n;
    const std::size_t size = Workspace::size(chain, m);
    Memory memory(size + 2 * n + (std::size_t)n * m);
    Workspace ws(chain, m, memory.packs());
    Pack *x = memory.packs() + size, *gradient = x + n, *scratch = gradient + n;
    for (std::int64_t row = begin; row < end; row += W) {
        const int count = lanes_left(row, end);
        load(q + row * n, n, count, n, x);
        decompose(chain, view, x, s, ws);
        Pack rank = fill(0.0);
        for (int i = 0; i < settings.generic; ++i)
            rank = rank + select(ws.sigma[i] > fill(settings.singular), fill(1.0), fill(0.0));
        const Attribution met = attribute(families, settings, fill((double)settings.generic) - rank, x, gradient);
        const Pack distance = first_order_distance(chain, view, families, settings, ws, scratch);
        store(ws.sigma, s, count, out.sigma + row * s, s);
        store_columns(ws.u, m, m, count, out.u + row * m * m, m * m);
        if (out.v) store_columns(ws.v, n, n, count, out.v + row * n * n, n * n);
        for (int lane = 0; lane < count; ++lane) {
            out.rank[row + lane] = (std::int32_t)get(rank, lane);
            out.family[row + lane] = (std::int32_t)get(met.family, lane);
            out.nearest[row + lane] = (std::int32_t)get(met.nearest, lane);
            out.residual[row + lane] = get(met.residual, lane);
            out.distance[row + lane] = get(distance, lane);
        }
    }
}

}  // namespace

extern const Kernels table;
#define RANKDROP_TEXT_(x) #x
#define RANKDROP_TEXT(x) RANKDROP_TEXT_(x)
const Kernels table{RANKDROP_TEXT(RANKDROP_ISA), W, pose, task_jacobian, derivative, decompose_range, block_range,
                    svd_range, newton, descend, enclose, nearest, links, monitor};

}  // namespace rankdrop::RANKDROP_ISA
