#pragma once

#include <cstdint>
#include <memory>

#include "core/analysis/frame_analysis.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/gpu_geometry.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// One frame of a scene by itself on the GPU, for whoever measures without writing a run folder.
/// Needs a context; `frame` refers to the other members.
struct StagedFrame {
    StagedFrame(std::shared_ptr<const Scene> scene, int index, int width, int height,
                std::uint32_t seed);
    StagedFrame(const StagedFrame&) = delete;
    StagedFrame& operator=(const StagedFrame&) = delete;

    TracedFrame traced;
    GBufferTextures textures;
    GpuMaterials materials;
    GpuGeometry geometry;
    LightBounds bounds;
    FrameAnalysis analysis;
    Frame frame;
};

}  // namespace penumbra
