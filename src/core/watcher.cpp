#include "watcher.hpp"

#include "monitor.hpp"

namespace rankdrop {

Watcher::Watcher(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings)
    : monitor_(std::make_unique<Monitor>(chain, view, families, settings)) {}

Watcher::~Watcher() = default;

bool Watcher::step(const double* q, const double* velocity, rankdrop_step& out) noexcept {
    return monitor_->step(q, velocity, out);
}

void Watcher::family(int number, double* distance, double* residual, double* away) const noexcept {
    const Monitor::Nearness one = monitor_->family(number);
    *distance = one.distance, *residual = one.residual;
    for (int j = 0; j < variables(); ++j) away[j] = one.away[j];
}

int Watcher::variables() const noexcept { return monitor_->variables(); }
int Watcher::families() const noexcept { return monitor_->families(); }
int Watcher::rows() const noexcept { return monitor_->rows(); }

}  // namespace rankdrop
