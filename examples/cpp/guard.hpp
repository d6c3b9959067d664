// Between whoever commands joint rates and the controller: joint states by name in, rates scaled out. Needs
// rankdrop/monitor.hpp alone; docs/howto/control-loop.md has a ROS 2 node around it.
#pragma once

#include <algorithm>
#include <cmath>
#include <rankdrop/monitor.hpp>
#include <string>
#include <vector>

class Guard {
  public:
    explicit Guard(const rankdrop_arm& arm) : arm_(arm), monitor_(arm), q_(static_cast<std::size_t>(arm.variables), NAN) {}

    // Values by name: drivers have an order, and further joints, of their own.
    void hear(const std::vector<std::string>& names, const std::vector<double>& values) {
        for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
            for (std::size_t j = 0; j < q_.size(); ++j)
                if (names[i] == arm_.variable_names[j]) q_[j] = values[i];
    }

    // Scales the rates and returns the factor: 0 until every joint was heard of, and where a number is not finite.
    double scale(std::vector<double>& rates) {
        const bool known = rates.size() == q_.size() && monitor_.step(q_.data(), rates.data(), seen_);
        const double s = known ? std::min(seen_.scaling, seen_.rate_scaling) : 0.0;
        for (double& rate : rates) rate = s > 0.0 ? s * rate : 0.0;
        return s;
    }

    // Of the last step: the family that is nearest, "" for none, and how near it is.
    std::string nearest() const { return seen_.nearest < 0 ? "" : monitor_.name(seen_.nearest); }
    double distance() const { return seen_.distance; }

  private:
    const rankdrop_arm& arm_;
    rankdrop::Monitor monitor_;
    std::vector<double> q_;
    rankdrop_step seen_{};
};
