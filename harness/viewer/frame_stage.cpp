#include "harness/viewer/frame_stage.hpp"

namespace penumbra {

void FrameStage::stage(const std::shared_ptr<const Scene>& scene, int index,
                       const SceneFrame& state, int width, int height, std::uint32_t seed) {
    frame_.reset();
    const bool sameScene = scene == scene_;
    if (!sameScene) {
        gpuGeometry_.reset();
        materials_ = std::make_unique<GpuMaterials>(scene->materials, scene->images);
    }
    if (!sameScene || state.geometry != geometry_) {
        // A tracer refers to its scene, and may outlive this stage in a reference's hands.
        tracer_ = std::shared_ptr<const Tracer>(
            new Tracer(state.geometry, scene->materials, scene->images),
            [scene](const Tracer* tracer) { delete tracer; });
        gpuGeometry_ = std::make_unique<GpuGeometry>(state.geometry, *materials_);
    }
    scene_ = scene;
    geometry_ = state.geometry;
    gbuffer_ =
        std::make_shared<const GBuffer>(renderGBuffer(*tracer_, state, *scene, width, height));
    textures_ = uploadGBuffer(*gbuffer_);
    const LightBounds bounds = boundLight(state.light, *gbuffer_, *state.geometry);
    analysis_ = analyseFrame(*scene, *tracer_, state.light, *gbuffer_, bounds);
    frame_.emplace(Frame{*scene, index, state.light, bounds, state.camera, state.geometry, *tracer_,
                         *gbuffer_, *textures_, *gpuGeometry_, analysis_.casterFacts, seed});
}

}  // namespace penumbra
