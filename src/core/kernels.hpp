// The kernels of one instruction set, as a table. Each works on rows begin … end - 1 of row-major batches.
#pragma once

#include <cstdint>

#include "families.hpp"
#include "model.hpp"
#include "settings.hpp"

namespace rankdrop {

struct Kernels {
    const char* name;
    int width;
    // (B, n) -> (B, 4, 4)
    void (*pose)(const Chain&, const double* q, std::int64_t begin, std::int64_t end, double* out);
    // (B, n) -> (B, m, n)
    void (*jacobian)(const Chain&, const View&, const double* q, std::int64_t begin, std::int64_t end, double* out);
    // (B, n) -> (B, m, n, n): out[b, a, i, k] = dJ[a, i]/dq_k
    void (*derivative)(const Chain&, const View&, const double* q, std::int64_t begin, std::int64_t end, double* out);
    // (B, n) -> sigma (B, s) and, where not null, u (B, m, m), v (B, n, n) with vectors as columns
    void (*decompose)(const Chain&, const View&, const double* q, std::int64_t begin, std::int64_t end, double* sigma,
                      double* u, double* v);
    // (B, n) -> sigma (B, s), f (B, p, r), d (B, p, r, n), u2 (B, m, p), v2 (B, n, r)
    void (*block)(const Chain&, const View&, int rank, const double* q, std::int64_t begin, std::int64_t end,
                  double* sigma, double* f, double* d, double* u2, double* v2);
    // (B, m, n) -> sigma (B, s) and, where not null, u (B, m, m), v (B, n, n)
    void (*svd)(int m, int n, const double* a, std::int64_t begin, std::int64_t end, double* sigma, double* u, double* v);
    void (*newton)(const Chain&, const View&, const SearchSettings&, const double* starts, std::int64_t begin,
                   std::int64_t end, std::int64_t first, const SearchOutput&, const volatile bool* stop);
    void (*descend)(const Chain&, const View&, const SearchSettings&, const double* starts, std::int64_t begin,
                    std::int64_t end, std::int64_t first, const SearchOutput&, const volatile bool* stop);
    // half (B, n) half-widths of boxes around q (B, n), or null for balls
    void (*enclose)(const Chain&, const View&, const EnclosureSettings&, const double* q, const double* half,
                    std::int64_t begin, std::int64_t end, const EnclosureOutput&);
    void (*nearest)(const Chain&, const View&, const NearestSettings&, const double* starts, std::int64_t begin,
                    std::int64_t end, const NearestOutput&, const volatile bool* stop);
    // (B, n) -> (B, joints + 2, 4, 4): base, every link, tip
    void (*links)(const Chain&, const double* q, std::int64_t begin, std::int64_t end, double* out);
    void (*monitor)(const Chain&, const View&, const Families&, const MonitorSettings&, const double* q, std::int64_t begin,
                    std::int64_t end, const SightingsOutput&);
};

// The table in use: the widest set this processor has, or the one asked for by name.
const Kernels& kernels();
// The table for single rows.
const Kernels& narrowest();
// Names of the sets this processor can run, narrowest first.
int available(const char** names, int room);
// False if there is no such set here.
bool choose(const char* name);

}  // namespace rankdrop
