// The C interface of the monitor.
#include <rankdrop/monitor.hpp>

#include <new>

struct rankdrop_monitor {
    rankdrop::Monitor monitor;
};

extern "C" {

rankdrop_monitor* rankdrop_monitor_new(const rankdrop_arm* arm) {
    if (!arm) return nullptr;
    try {
        return new rankdrop_monitor{rankdrop::Monitor(*arm)};
    } catch (...) {
        return nullptr;
    }
}

void rankdrop_monitor_free(rankdrop_monitor* monitor) { delete monitor; }

int rankdrop_monitor_step(rankdrop_monitor* monitor, const double* q, const double* velocity, rankdrop_step* out) {
    return monitor->monitor.step(q, velocity, *out) ? 1 : 0;
}

double rankdrop_monitor_at_least(const rankdrop_monitor* monitor, const double* q) {
    try {
        return monitor->monitor.at_least(q);
    } catch (...) {
        return 0.0;
    }
}

int rankdrop_monitor_family(const rankdrop_monitor* monitor, int family, double* distance, double* residual, double* away) {
    if (family < 0 || family >= monitor->monitor.families()) return 0;
    const rankdrop::Monitor::Nearness one = monitor->monitor.family(family);
    *distance = one.distance, *residual = one.residual;
    for (int j = 0; j < monitor->monitor.variables(); ++j) away[j] = one.away[j];
    return 1;
}

}  // extern "C"
