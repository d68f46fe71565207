#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/trace/tracer.hpp"

namespace penumbra {

/// Points of the light, in its (s, t) in [0,1)^2, and what one pixel sees of them.
struct LightBatch {
    static constexpr std::size_t kCapacity = Tracer::kStreamSize;
    std::size_t size = 0;
    std::array<float, kCapacity> s, t;
    std::array<float, kCapacity> weight;  ///< max(0, cosP) max(0, cosL) / r^2
    std::array<std::uint8_t, kCapacity> visible;
};

/// One pixel's view of the light.
class LightProbe {
  public:
    virtual ~LightProbe() = default;
    /// Fills `weight`.
    virtual void weigh(LightBatch& batch) = 0;
    /// Fills `visible`, one ray per point.
    virtual void look(LightBatch& batch) = 0;
};

}  // namespace penumbra
