// The monitor of single configurations for the bindings: compiled like the kernels, without contraction.
#pragma once

#include <memory>

#include "families.hpp"
#include "model.hpp"
#include "monitor.h"

namespace rankdrop {

class Monitor;

class Watcher {
  public:
    Watcher(const Chain& chain, const View& view, const Families& families, const MonitorSettings& settings);
    ~Watcher();
    bool step(const double* q, const double* velocity, rankdrop_step& out) noexcept;
    void family(int number, double* distance, double* residual, double* away) const noexcept;
    int variables() const noexcept;
    int families() const noexcept;
    int rows() const noexcept;

  private:
    std::unique_ptr<Monitor> monitor_;
};

}  // namespace rankdrop
