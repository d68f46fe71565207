#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>

#include "core/analysis/frame_analysis.hpp"
#include "core/frame/gpu_geometry.hpp"
#include "core/gl/context.hpp"
#include "methods/shadow_method.hpp"

/// What benchmarks of GPU work share.
namespace penumbra::bench {

/// Makes the default context unless this process has it already.
void needContext();

/// A scene's first frame on the GPU. Needs a context.
struct Stage {
    std::shared_ptr<const Scene> scene;
    SceneFrame moment;
    Tracer tracer;
    GBuffer gbuffer;
    GBufferTextures textures;
    GpuMaterials materials;
    GpuGeometry geometry;
    LightBounds bounds;
    FrameAnalysis analysis;
    Frame frame;

    /// `change` may make another light of the scene's, `changeCamera` another camera.
    Stage(const std::string& id, int width, int height,
          const std::function<void(AreaLight&)>& change = {},
          const std::function<void(Camera&)>& changeCamera = {});
    Stage(const std::string& id, int pixels) : Stage(id, pixels, pixels) {}
    Stage(const Stage&) = delete;  // `frame` refers to the other members
    Stage& operator=(const Stage&) = delete;

    /// The method with `settings` applied, its plan for this scene made and prepared for.
    struct Act {
        std::unique_ptr<ShadowMethod> method;
        Plan plan;
    };
    Act act(const std::string& methodId, const Assignments& settings) const;
};

/// Fenced time of `work`, milliseconds.
double fencedMs(const auto& work) {
    const gl::FencedTimer timer;
    work();
    return timer.stop();
}

/// The lesser of `least` and the time of `work`: neighbours on the machine only ever add.
double leastMs(double least, const auto& work) {
    return std::min(least, fencedMs(work));
}

}  // namespace penumbra::bench
