#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/analysis/frame_analysis.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/gpu_geometry.hpp"

namespace penumbra {

/// The frame that the window shows, staged as StagedFrame does, where the one before it shares most
/// with it: only what changed is made anew. Needs a context.
class FrameStage {
  public:
    /// `state` may have another camera or light than `scene` has in its frame `index`.
    void stage(const std::shared_ptr<const Scene>& scene, int index, const SceneFrame& state,
               int width, int height, std::uint32_t seed);

    bool staged() const { return frame_.has_value(); }
    /// The rest is there once staged; what the shared pointers hold never changes.
    const Frame& frame() const { return *frame_; }
    const EffectFindings& findings() const { return analysis_.findings; }
    const std::shared_ptr<const Scene>& scene() const { return scene_; }
    const std::shared_ptr<const Tracer>& tracer() const { return tracer_; }
    const std::shared_ptr<const GBuffer>& gbuffer() const { return gbuffer_; }

  private:
    std::shared_ptr<const Scene> scene_;
    std::shared_ptr<const Geometry> geometry_;
    std::shared_ptr<const Tracer> tracer_;
    std::shared_ptr<const GBuffer> gbuffer_;
    std::optional<GBufferTextures> textures_;
    std::unique_ptr<GpuMaterials> materials_;
    std::unique_ptr<GpuGeometry> gpuGeometry_;
    FrameAnalysis analysis_;
    std::optional<Frame> frame_;
};

}  // namespace penumbra
