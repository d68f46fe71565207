#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "harness/report/summary.hpp"

namespace penumbra {

/// Where the time of a run goes.
class PhaseClock {
  public:
    template <class Work>
    auto measure(const std::string& phase, const Work& work) {
        struct Guard {
            double& total;
            std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
            ~Guard() {
                total +=
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            }
        } guard{seconds_[phase]};
        return work();
    }
    void add(const std::string& phase, double seconds) { seconds_[phase] += seconds; }
    std::vector<PhaseTime> phases() const {
        std::vector<PhaseTime> list;
        for (const auto& [name, seconds] : seconds_) list.push_back({name, seconds});
        return list;
    }

  private:
    std::map<std::string, double> seconds_;
};

}  // namespace penumbra
