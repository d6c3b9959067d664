// Run-time choice among the instruction sets the core was built for.
#include <cstring>

#include "kernels.hpp"

namespace rankdrop {

namespace baseline { extern const Kernels table; }
#if defined(RANKDROP_HAVE_X86_SETS)
namespace avx2 { extern const Kernels table; }
namespace avx512 { extern const Kernels table; }
#endif

namespace {

int runnable(const Kernels** tables) {
    int count = 0;
    tables[count++] = &baseline::table;
#if defined(RANKDROP_HAVE_X86_SETS)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2")) tables[count++] = &avx2::table;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) tables[count++] = &avx512::table;
#endif
    return count;
}

const Kernels*& chosen() {
    static const Kernels* table = [] {
        const Kernels* tables[3];
        return tables[runnable(tables) - 1];
    }();
    return table;
}

}  // namespace

const Kernels& kernels() { return *chosen(); }

const Kernels& narrowest() { return baseline::table; }

int available(const char** names, int room) {
    const Kernels* tables[3];
    const int count = runnable(tables);
    for (int i = 0; i < count && i < room; ++i) names[i] = tables[i]->name;
    return count;
}

bool choose(const char* name) {
    const Kernels* tables[3];
    const int count = runnable(tables);
    for (int i = 0; i < count; ++i)
        if (std::strcmp(tables[i]->name, name) == 0) {
            chosen() = tables[i];
            return true;
        }
    return false;
}

}  // namespace rankdrop
