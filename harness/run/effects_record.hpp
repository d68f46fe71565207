#pragma once

#include <string>

#include "core/effects/effects.hpp"

namespace penumbra {

/// What analysis found out about one frame of a run, and what that took.
struct EffectsRecord {
    std::string scene;
    int frame = 0;
    /// Of making the frame without its analysis: geometry, BVH, upload and G-buffer, and in a
    /// scene's first one reading the asset.
    double loadMs = 0.0;
    double analysisMs = 0.0;
    EffectFindings findings;
};

}  // namespace penumbra
