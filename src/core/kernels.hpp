// The kernels of one instruction set, as a table. Each works on rows begin … end - 1 of row-major batches.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "families.hpp"
#include "model.hpp"
#include "settings.hpp"
#include "split.hpp"
#include "watcher.hpp"

namespace rankdrop {

// What `block` writes.
struct BlockOutput {
    double* sigma;  // (B, s)
    double* f;      // (B, p, r)
    double* d;      // (B, p, r, n)
    double* u2;     // (B, m, p)
    double* v2;     // (B, n, r)
};

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
    void (*block)(const Chain&, const View&, int rank, const double* q, std::int64_t begin, std::int64_t end,
                  const BlockOutput&);
    // (B, m, n) -> sigma (B, s) and, where not null, u (B, m, m), v (B, n, n)
    void (*svd)(int m, int n, const double* a, std::int64_t begin, std::int64_t end, double* sigma, double* u, double* v);
    void (*newton)(const Chain&, const View&, const SearchSettings&, const double* starts, std::int64_t begin,
                   std::int64_t end, std::int64_t first, const SearchOutput&, const std::atomic<bool>& stop);
    void (*descend)(const Chain&, const View&, const SearchSettings&, const double* starts, std::int64_t begin,
                    std::int64_t end, std::int64_t first, const SearchOutput&, const std::atomic<bool>& stop);
    // half (B, n) half-widths of boxes around q (B, n), or null for balls
    void (*enclose)(const Chain&, const View&, const EnclosureSettings&, const double* q, const double* half,
                    std::int64_t begin, std::int64_t end, const EnclosureOutput&);
    // boxes cut by balls
    void (*enclose_cut)(const Chain&, const View&, const EnclosureSettings&, const double* q, const double* half,
                        std::int64_t begin, std::int64_t end, const Cut&);
    void (*nearest)(const Chain&, const View&, const NearestSettings&, const double* starts, std::int64_t begin,
                    std::int64_t end, const NearestOutput&, const std::atomic<bool>& stop);
    // starts q (B, n) in and out; met (B): how each ended
    void (*set_feet)(const Chain&, const View&, const SetFeetSettings&, double* q, std::int64_t count, std::int8_t* met,
                     double* far);
    // (B, n) -> (B, joints + 2, 4, 4): base, every link, tip
    void (*links)(const Chain&, const double* q, std::int64_t begin, std::int64_t end, double* out);
    void (*monitor)(const Chain&, const View&, const Families&, const MonitorSettings&, const double* q, std::int64_t begin,
                    std::int64_t end, const SightingsOutput&);
    // points that walks of lengthy families begin at, once for a table
    void (*spread)(const Chain&, const View&, Families&, const MonitorSettings&);
    // (B, n) -> f (B, e) and, where not null, its gradients (B, e, n)
    void (*equations)(const Families&, const double* q, std::int64_t begin, std::int64_t end, double* f, double* slopes);
    // q (B, n) in and out; worst (B): the largest |f| that is left
    void (*zeros)(const Families&, const ZeroSettings&, double* q, std::int64_t begin, std::int64_t end, double* worst);
    // q (B, n) in and out: the points of a family nearest to a configuration that starts come to
    void (*feet)(const Families&, const FootSettings&, double* q, std::int64_t begin, std::int64_t end);
    // boxes begin … end - 1 of the top level, one tree for each
    void (*cover)(const Split&, std::int64_t begin, std::int64_t end, CoverTree* out);
    // leaves (B, 4) by their places, halved so many times in so many parts: free (0), proven to hold a singularity (1), or neither (2)
    void (*judge)(const Split&, const std::int32_t* leaves, int halvings, std::int64_t parts, std::int64_t begin, std::int64_t end,
                  std::int8_t* out);
    // Bernstein coefficients (15, 16) of one box of a level
    void (*shape)(const Split&, int level, const std::int32_t* place, double* out);
};

// The table in use: the widest set this processor has, or the one asked for by name.
const Kernels& kernels();
// The table with one lane, for single rows.
const Kernels& narrowest();
// A monitor of single configurations. Where families are walked to by the kinematics (`walks`) it takes as many lanes as
// there are walks, if that many were asked for.
std::unique_ptr<Watcher> watch(bool walks, const Chain&, const View&, const Families&, const MonitorSettings&);
// The quickest table for so many rows: all give the same bits.
const Kernels& kernels(std::size_t rows);
// Names of the sets this processor can run, narrowest first.
std::vector<std::string> available();
// False if there is no such set here.
bool choose(const std::string& name);

}  // namespace rankdrop
