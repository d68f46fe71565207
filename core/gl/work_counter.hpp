#pragma once

#include <cstdint>

namespace penumbra::gl {

/// Work submitted to OpenGL that is the same on every machine.
struct Work {
    std::uint64_t drawCalls = 0;  ///< draws and compute dispatches
    std::uint64_t triangles = 0;  ///< primitives submitted
    std::uint64_t fragments = 0;  ///< fragment shader invocations
};

/// Counts everything that any code submits while it lives: draw calls by wrapping the loaded entry
/// points, triangles and fragments by pipeline-statistics queries. One at a time; not inside a timed
/// section.
class WorkCounter {
  public:
    WorkCounter();
    ~WorkCounter();
    WorkCounter(const WorkCounter&) = delete;
    WorkCounter& operator=(const WorkCounter&) = delete;
    /// Ends the count. Waits for the GPU. Without pipeline-statistics queries triangles and fragments
    /// stay 0 and `statistics` is false.
    Work stop();
    bool statistics() const { return statistics_; }

  private:
    bool statistics_ = false, running_ = true;
    unsigned queries_[2] = {0, 0};
};

}  // namespace penumbra::gl
