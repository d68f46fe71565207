#pragma once

#include <cstdint>
#include <memory>

#include "core/frame/caster_facts.hpp"
#include "core/frame/gbuffer.hpp"
#include "core/frame/gpu_geometry.hpp"
#include "core/frame/light_bounds.hpp"
#include "core/gl/handles.hpp"
#include "core/scene/scene.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// The G-buffer on the GPU; row 0 of each texture is the image's top row.
struct GBufferTextures {
    gl::Texture position;  ///< RGBA32F: relative position in metres, PixelClass
    gl::Texture normal;    ///< RGBA32F: geometric normal, 0
};

/// A scene at one time, as const data: all that a method may know.
struct Frame {
    const Scene& scene;
    int index = 0;
    AreaLight light;
    LightBounds lightBounds;  ///< of the receivers seen and the casters, for LightView::fit
    Camera camera;
    std::shared_ptr<const Geometry> geometry;
    const Tracer& tracer;
    const GBuffer& gbuffer;
    const GBufferTextures& gbufferTextures;
    const GpuGeometry& gpuGeometry;
    CasterFacts casterFacts;  ///< of `geometry`
    std::uint32_t seed = 0;   ///< of this run; two frames of one seed give the same image

    int width() const { return gbuffer.width; }
    int height() const { return gbuffer.height; }
};

GBufferTextures uploadGBuffer(const GBuffer& gbuffer);

}  // namespace penumbra
