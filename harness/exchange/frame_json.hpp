#pragma once

#include <string>

#include "harness/run/truth.hpp"

namespace penumbra {

/// Names of what is exported beside the JSON.
struct FrameFiles {
    std::string glb, gbuffer, reference;
};

/// A frame's camera, light, pixel classes and conventions for other renderers: world metres, JSON.
/// Its last member says in words how to read the others. `camera` is the frame's own with finite
/// clip distances (withClipPlanes).
std::string frameJson(const TracedFrame& traced, const Camera& camera, const TruthOptions& options,
                      const FrameFiles& files);

}  // namespace penumbra
