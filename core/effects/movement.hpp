#pragma once

#include "core/effects/effects.hpp"
#include "core/scene/scene.hpp"

namespace penumbra {

/// What changes between a scene's frames: tracks that are constant move nothing. Each is the first
/// frame in which it is another than in frame 0; 0 where it is the same in all.
struct Movement {
    int light = 0, casters = 0, camera = 0;
    bool operator==(const Movement&) const = default;

    /// Evaluates frames, where there are tracks, until they are seen to change something.
    static Movement of(const Scene& scene);
    /// Fills in moving_light, moving_casters and moving_camera.
    void tell(EffectFindings& findings) const;
};

}  // namespace penumbra
