// Run-time choice among the instruction sets the core was built for.
#include <algorithm>
#include <atomic>

#include "kernels.hpp"
#include "svd_of_one.hpp"

namespace rankdrop {

using Watch = std::unique_ptr<Watcher>(const Chain&, const View&, const Families&, const MonitorSettings&);

namespace single { extern const Kernels table; }
namespace baseline { extern const Kernels table; Watch watch; }
#if defined(RANKDROP_HAVE_X86_SETS)
namespace avx2 { extern const Kernels table; Watch watch; }
namespace avx512 { extern const Kernels table; Watch watch; }
#endif

namespace {

// The tables that this processor can run, narrowest first.
std::vector<const Kernels*> runnable() {
    std::vector<const Kernels*> tables{&single::table, &baseline::table};
#if defined(RANKDROP_HAVE_X86_SETS)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2")) tables.push_back(&avx2::table);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) tables.push_back(&avx512::table);
#endif
    return tables;
}

std::atomic<const Kernels*>& chosen() {
    static std::atomic<const Kernels*> table{runnable().back()};
    return table;
}

}  // namespace

const Kernels& kernels() { return *chosen().load(std::memory_order_relaxed); }

std::unique_ptr<Watcher> watch(bool walks, const Chain& chain, const View& view, const Families& families,
                               const MonitorSettings& settings) {
    // 8 walks of one configuration (onto_set.hpp); without walks the cost of wider registers counts
    const int lanes = std::min(walks ? 8 : 4, kernels().width);
    Watch* best = baseline::watch;
#if defined(RANKDROP_HAVE_X86_SETS)
    if (avx2::table.width <= lanes) best = avx2::watch;  // what is asked for runs here, and so does what is narrower
    if (avx512::table.width <= lanes) best = avx512::watch;
#endif
    return best(chain, view, families, settings);
}

bool svd_of_one([[maybe_unused]] double* matrix, [[maybe_unused]] int rows, [[maybe_unused]] int columns,
                [[maybe_unused]] double* sigma, [[maybe_unused]] double* vectors) {
#if defined(RANKDROP_HAVE_X86_SETS)
    if (kernels().width >= avx2::table.width) return avx2::svd_of_one(matrix, rows, columns, sigma, vectors);
#endif
    return false;
}

const Kernels& narrowest() { return single::table; }

const Kernels& kernels(std::size_t rows) {
    return rows <= 1 ? narrowest() : rows <= static_cast<std::size_t>(baseline::table.width) ? baseline::table : kernels();
}

std::vector<std::string> available() {
    std::vector<std::string> names;
    for (const Kernels* table : runnable()) names.emplace_back(table->name);
    return names;
}

bool choose(const std::string& name) {
    for (const Kernels* table : runnable())
        if (name == table->name) {
            chosen() = table;
            return true;
        }
    return false;
}

}  // namespace rankdrop
