#pragma once

#include <chrono>
#include <string>

namespace penumbra {

/// Progress on stderr: on a terminal one line that rewrites itself, with the time left; elsewhere
/// one plain line per step.
class ProgressLine {
  public:
    explicit ProgressLine(std::size_t steps);
    ~ProgressLine();
    /// Step `done` of `steps` begins: `what` it is.
    void step(std::size_t done, const std::string& what);
    /// How far the current step has come, in [0,1]; shown on terminals only.
    void within(double fraction);
    /// A line that stays.
    void note(const std::string& text);

  private:
    void show(double fraction);
    std::size_t steps_, done_ = 0;
    std::string what_;
    bool terminal_;
    bool open_ = false;
    std::chrono::steady_clock::time_point start_, shown_;
};

}  // namespace penumbra
