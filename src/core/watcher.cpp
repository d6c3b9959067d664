// The monitor of the headers behind `Watcher`, one build for each instruction set.
#include "watcher.hpp"

#include "kernels.hpp"
#include "monitor.hpp"

namespace rankdrop::RANKDROP_ISA {
namespace {

class Watching final : public Watcher {
  public:
    Watching(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings)
        : monitor_(chain, view, families, settings) {}

    bool step(const double* q, const double* velocity, rankdrop_step& out) noexcept override {
        return monitor_.step(q, velocity, out);
    }

    void family(int number, double* distance, double* residual, double* away) const noexcept override {
        const Monitor::Nearness one = monitor_.family(number);
        *distance = one.distance, *residual = one.residual;
        for (int j = 0; j < variables(); ++j) away[j] = one.away[j];
    }

    int variables() const noexcept override { return monitor_.variables(); }
    int families() const noexcept override { return monitor_.families(); }
    int rows() const noexcept override { return monitor_.rows(); }

  private:
    Monitor monitor_;
};

}  // namespace

std::unique_ptr<Watcher> watch(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings) {
    return std::make_unique<Watching>(chain, view, families, settings);
}

}  // namespace rankdrop::RANKDROP_ISA
