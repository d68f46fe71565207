#pragma once

#include <tbb/global_control.h>

#include <cstdlib>
#include <string>

namespace penumbra {

/// Bounds this program's threads, and those of a software renderer whose context is made later, for
/// as long as it lives.
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads)
        : limit_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {
        setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);  // read by llvmpipe
    }

  private:
    tbb::global_control limit_;
};

}  // namespace penumbra
