#pragma once

#include <vector>

#include "core/analysis/receivers.hpp"
#include "core/effects/effects.hpp"
#include "core/effects/movement.hpp"
#include "core/frame/caster_facts.hpp"
#include "core/frame/light_bounds.hpp"
#include "core/scene/scene.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// Which effects a frame calls for, and why, with what is known of its parts.
///
/// An effect is called for where sampled light rays show it, and where they do not but nothing
/// proves that it is absent; it is not called for where that is proven. Proofs are of bounds that
/// hold every light ray, never of samples. They hold for methods whose maps have 64 texels across
/// or more (see kClearance in frame_analysis.cpp).
struct FrameAnalysis {
    EffectFindings findings;
    CasterFacts casterFacts;

    EffectSet calledFor() const { return findings.calledFor(); }
};

/// Of the geometry that `tracer` has under the receivers' light. `bounds` are those receivers'.
/// Same input, same result, on any number of threads.
FrameAnalysis analyseFrame(const Scene& scene, const Movement& movement, const Tracer& tracer,
                           const Receivers& receivers, const LightBounds& bounds);

/// A frame by itself: the receivers are those of one G-buffer.
FrameAnalysis analyseFrame(const Scene& scene, const Tracer& tracer, const AreaLight& light,
                           const GBuffer& gbuffer, const LightBounds& bounds);

}  // namespace penumbra
