// guard ARM < rows: each line holds q and joint rates; each line out the factor, the rates scaled, distance and nearest
// family. The first line out is of rates that come before any joint was heard of.
#include "guard.hpp"

#include <cstdio>
#include <cstring>

#include "arms.h"

int main(int count, char** words) {
    const rankdrop_arm* arm = nullptr;
    for (const rankdrop_arm* one : arms)
        if (count == 2 && std::strcmp(one->name, words[1]) == 0) arm = one;
    if (!arm) return 2;
    Guard guard(*arm);
    const std::size_t n = static_cast<std::size_t>(arm->variables);
    std::vector<std::string> names{"a_gripper"};
    for (std::size_t j = n; j-- > 0;) names.emplace_back(arm->variable_names[j]);  // last joint first
    std::vector<double> rates(n, 1.0), values(n + 1, 7.0);
    std::printf("%.17g\n", guard.scale(rates));
    for (;;) {
        for (std::size_t j = 0; j < n; ++j)
            if (std::scanf("%lf", &values[n - j]) != 1) return 0;
        for (double& rate : rates)
            if (std::scanf("%lf", &rate) != 1) return 2;
        guard.hear(names, values);
        std::printf("%.17g", guard.scale(rates));
        for (const double rate : rates) std::printf(" %.17g", rate);
        std::printf(" %.17g %s\n", guard.distance(), guard.nearest().c_str());
    }
}
