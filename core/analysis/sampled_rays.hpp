#pragma once

#include <cstddef>
#include <vector>

#include "core/analysis/receivers.hpp"
#include "core/frame/casters.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// What rays from some of the points that are asked about to random points of the light meet: what
/// is there for certain. What they miss may be there all the same.
struct SampledRays {
    std::size_t rays = 0, blocked = 0;
    /// Of those that were followed all the way: how many, how many met two casters or one twice,
    /// and how many start on a part that blocks some of them.
    std::size_t followed = 0, layered = 0, onCasters = 0;
    std::vector<char> blocks;  ///< one for each part of the geometry

    /// Same input, same result, on any number of threads.
    static SampledRays trace(const Tracer& tracer, const Receivers& receivers,
                             const Casters& bodies);
};

}  // namespace penumbra
