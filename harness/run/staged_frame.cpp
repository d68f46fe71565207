#include "harness/run/staged_frame.hpp"

#include <utility>

namespace penumbra {

StagedFrame::StagedFrame(std::shared_ptr<const Scene> scene, int index, int width, int height,
                         std::uint32_t seed)
    : traced(traceFrame(std::move(scene), index, width, height)),
      textures(uploadGBuffer(traced.gbuffer)),
      materials(traced.scene->materials, traced.scene->images),
      geometry(traced.frame.geometry, materials),
      bounds(boundLight(traced.frame.light, traced.gbuffer, *traced.frame.geometry)),
      analysis(
          analyseFrame(*traced.scene, *traced.tracer, traced.frame.light, traced.gbuffer, bounds)),
      frame{*traced.scene,
            index,
            traced.frame.light,
            bounds,
            traced.frame.camera,
            traced.frame.geometry,
            *traced.tracer,
            traced.gbuffer,
            textures,
            geometry,
            analysis.casterFacts,
            seed} {}

}  // namespace penumbra
