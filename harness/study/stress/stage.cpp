#include "harness/study/stress/stage.hpp"

#include "core/gl/context.hpp"
#include "harness/reference/exact.hpp"
#include "harness/run/cells.hpp"

namespace penumbra::stress {

StageFrame::StageFrame(const Scene& scene, int index, int size, std::uint32_t seed,
                       const GpuMaterials& materials)
    : sceneFrame_(scene.frame(index)),
      tracer_(sceneFrame_.geometry, scene.materials, scene.images),
      gbuffer_(renderGBuffer(tracer_, sceneFrame_, scene, size, size)),
      textures_(uploadGBuffer(gbuffer_)),
      gpuGeometry_(sceneFrame_.geometry, materials),
      calledFor_(effectsCalledFor(scene, sceneFrame_)),
      frame_{scene,
             index,
             sceneFrame_.light,
             boundLight(sceneFrame_.light, gbuffer_, *sceneFrame_.geometry),
             sceneFrame_.camera,
             sceneFrame_.geometry,
             tracer_,
             gbuffer_,
             textures_,
             gpuGeometry_,
             seed} {
    for (std::size_t i = 0; i < gbuffer_.size(); ++i)
        if (gbuffer_.mask[i] == PixelClass::scored || gbuffer_.mask[i] == PixelClass::horizon)
            asked_.push_back(i);
}

const std::vector<float>& StageFrame::exact() const {
    if (exact_.empty())
        exact_ = exactReference(tracer_, frame_.scene.materials, gbuffer_, frame_.light).visibility;
    return exact_;
}

std::optional<bool> StageFrame::centreSeen(std::size_t i, double edgeM) const {
    const AreaLight& light = frame_.light;
    const glm::dvec3 point(gbuffer_.position[i]), normal(gbuffer_.geometricNormal[i]);
    constexpr int kReach = 2;
    Tracer::Stream rays(tracer_);
    for (int y = -kReach; y <= kReach; ++y)
        for (int x = -kReach; x <= kReach; ++x) {
            const glm::dvec3 sideways =
                edgeM / kReach *
                (static_cast<double>(x) * light.axisU + static_cast<double>(y) * light.axisV);
            const glm::dvec3 direction = point + sideways - light.centre;
            const double t = glm::dot(normal, point - light.centre) / glm::dot(normal, direction);
            if (!(t > 0.5 && t < 2.0)) return std::nullopt;  // the surface is all but edge-on
            const glm::vec3 beside(light.centre + t * direction);
            rays.add(tracer_.shadowOrigin(beside, glm::vec3(normal)), glm::vec3(light.centre));
        }
    rays.trace();
    for (std::size_t k = 1; k < rays.size(); ++k)
        if (rays.blocked(k) != rays.blocked(0)) return std::nullopt;
    return !rays.blocked(0);
}

Stage::Stage(std::shared_ptr<const Scene> scene, int size, std::uint32_t seed)
    : scene_(std::move(scene)), size_(size), materials_(scene_->materials, scene_->images) {
    for (int i = 0; i < scene_->frameCount(); ++i)
        frames_.push_back(std::make_unique<StageFrame>(*scene_, i, size, seed, materials_));
}

std::vector<Image> render(const Setting& setting, const Stage& stage) {
    SettingRun run(setting);
    const TextureTarget target(stage.size(), stage.size());
    const EffectSet simulates = setting.make()->traits().simulates;
    std::vector<Image> images;
    try {
        for (const auto& frame : stage.frames()) {
            Row row;
            const Plan plan = planFor({}, frame->calledFor(), simulates);
            run.warmUp(frame->frame(), plan, false, target, row);
            images.push_back(run.visibility());
        }
    } catch (...) {
        gl::takeErrors();
        throw;
    }
    return images;
}

}  // namespace penumbra::stress
