// watch ARM < rows: each line holds q and joint rates; each line out what the monitor says there. Exit code 3 where a step
// has allocated memory.
#include <rankdrop/monitor.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "arms.h"

static long allocations = 0;

#if defined(__GNUC__)
#define APART __attribute__((noinline))  // inlined, GCC takes new and free for a mismatch
#else
#define APART
#endif
APART void* operator new(std::size_t bytes) {
    ++allocations;
    if (void* memory = std::malloc(bytes ? bytes : 1)) return memory;
    throw std::bad_alloc();
}
APART void operator delete(void* memory) noexcept { std::free(memory); }
APART void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

static void print(const double* values, int count) {
    for (int i = 0; i < count; ++i) std::printf(" %.17g", values[i]);
}

int main(int count, char** words) {
    const rankdrop_arm* arm = nullptr;
    for (const rankdrop_arm* one : arms)
        if (count == 2 && std::strcmp(one->name, words[1]) == 0) arm = one;
    if (!arm) {
        std::fprintf(stderr, "usage: watch ARM < rows; arms:");
        for (const rankdrop_arm* one : arms) std::fprintf(stderr, " %s", one->name);
        std::fprintf(stderr, "\n");
        return 2;
    }
    rankdrop::Monitor monitor(*arm);
    const int n = monitor.variables(), m = monitor.rows();
    std::vector<double> q(n), rates(n);
    rankdrop_step seen;
    long inside = 0;
    for (;;) {
        for (double& value : q)
            if (std::scanf("%lf", &value) != 1) return inside == 0 ? 0 : 3;
        for (double& value : rates)
            if (std::scanf("%lf", &value) != 1) return 2;
        const long before = allocations;
        monitor.step(q.data(), rates.data(), seen);
        inside += allocations - before;
        std::printf("%s", seen.nearest < 0 ? "none" : monitor.id(seen.nearest).c_str());
        std::printf(" %s %d %d", seen.family < 0 ? "none" : monitor.id(seen.family).c_str(), seen.rank, seen.corank);
        const double numbers[] = {seen.residual, seen.distance,     seen.approach,
                                  seen.scaling,  seen.rate_scaling, seen.null_rate,
                                  monitor.at_least(q.data())};
        print(numbers, 7);
        print(seen.sigma, m < n ? m : n), print(seen.u, m * m), print(seen.null_step, n);
        for (int f = 0; f < monitor.families(); ++f) {
            const rankdrop::Monitor::Nearness one = monitor.family(f);
            print(&one.distance, 1), print(&one.residual, 1), print(one.away, n);
        }
        std::printf("\n");
    }
}
