// The monitor of single configurations for the bindings, whichever instruction set it was built for.
#pragma once

#include "monitor.h"

namespace rankdrop {

class Watcher {
  public:
    virtual ~Watcher() = default;
    virtual bool step(const double* q, const double* velocity, rankdrop_step& out) noexcept = 0;
    virtual void family(int number, double* distance, double* residual, double* away) const noexcept = 0;
    virtual int variables() const noexcept = 0;
    virtual int families() const noexcept = 0;
    virtual int rows() const noexcept = 0;
};

}  // namespace rankdrop
