#pragma once

#include "core/parameter/parameter.hpp"

namespace penumbra {

/// The parameter `bias` of every method whose receivers are compared with a map of nearM / z by
/// litAt of shaders/common/light_view.glsl.
class MapBias : public FloatParameter {
  public:
    explicit MapBias(Parameters* owner)
        : FloatParameter(owner, "bias", 0.5, 0.0, 64.0, "texels",
                         "how far towards the light a receiver is moved before the comparison, in "
                         "texel footprints at its depth") {}
};

}  // namespace penumbra
