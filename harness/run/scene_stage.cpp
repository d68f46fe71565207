#include "harness/run/scene_stage.hpp"

#include <chrono>

namespace penumbra {

SceneStage::Placed::Placed(std::shared_ptr<const Geometry> shape, const Scene& scene,
                           const GpuMaterials& materials)
    : geometry(std::move(shape)),
      tracer(geometry, scene.materials, scene.images),
      gpu(geometry, materials) {}

SceneStage::SceneStage(const Scene& scene, int width, int height, std::uint32_t seed)
    : scene_(scene),
      width_(width),
      height_(height),
      seed_(seed),
      movement_(Movement::of(scene)),
      firstMoment_(scene.frame(0)),
      materials_(scene.materials, scene.images) {}

SceneStage::~SceneStage() = default;

void SceneStage::enter(int index) {
    for (std::optional<View>& view : views_) view.reset();
    analysisMs_ = 0.0;
    index_ = index;
    now_ = scene_.frame(index);
    current_.reset();
    if (now_.geometry != firstMoment_.geometry)
        current_ = std::make_unique<Placed>(now_.geometry, scene_, materials_);
    const Tracer& tracer = current_ ? current_->tracer : first().tracer;
    gbuffer_ = renderGBuffer(tracer, now_, scene_, width_, height_);
    textures_ = uploadGBuffer(gbuffer_);
}

const SceneStage::Placed& SceneStage::first() {
    if (!first_) first_ = std::make_unique<Placed>(firstMoment_.geometry, scene_, materials_);
    return *first_;
}

const Frame& SceneStage::frameFor(const Plan& plan) {
    return view({!plan.has(Effect::moving_light), !plan.has(Effect::moving_casters)}).frame;
}

const SceneStage::View& SceneStage::view(Held held) {
    // What does not move cannot be told from what is held.
    const bool movesLight = movement_.light && !held.light;
    const bool movesCasters = movement_.casters && !held.casters;
    std::optional<View>& view = views_[2 * movesLight + movesCasters];
    if (view) return *view;
    const Placed& placed = movesCasters && current_ ? *current_ : first();
    const AreaLight& light = movesLight ? now_.light : firstMoment_.light;
    if (!movesLight && !movesCasters && !still_) still_ = factsOf(light, placed, true);
    const LightSpaceFacts facts =
        movesLight || movesCasters ? factsOf(light, placed, false) : *still_;
    view.emplace(
        View{facts.analysis,
             {scene_, index_, light, facts.bounds, now_.camera, placed.geometry, placed.tracer,
              gbuffer_, textures_, placed.gpu, facts.analysis.casterFacts, seed_}});
    return *view;
}

SceneStage::LightSpaceFacts SceneStage::factsOf(const AreaLight& light, const Placed& placed,
                                                bool ofAllFrames) {
    using Clock = std::chrono::steady_clock;
    Clock::duration spent{};
    Receivers receivers(light);
    std::optional<LightBounds> bounds;
    const auto add = [&](const GBuffer& gbuffer) {
        const LightBounds here = boundLight(light, gbuffer, *placed.geometry);
        bounds = bounds ? united(*bounds, here) : here;
        const auto start = Clock::now();
        receivers.add(gbuffer);
        spent += Clock::now() - start;
    };
    const bool allAlike = !movement_.light && !movement_.casters && !movement_.camera;
    if (!ofAllFrames || allAlike) {
        add(gbuffer_);
    } else {
        for (int i = 0; i < scene_.frameCount(); ++i) {
            if (i == index_) {
                add(gbuffer_);
                continue;
            }
            const SceneFrame moment = scene_.frame(i);
            if (moment.geometry == placed.geometry) {
                add(renderGBuffer(placed.tracer, moment, scene_, width_, height_));
            } else {
                const Tracer tracer(moment.geometry, scene_.materials, scene_.images);
                add(renderGBuffer(tracer, moment, scene_, width_, height_));
            }
        }
    }
    const auto start = Clock::now();
    FrameAnalysis analysis = analyseFrame(scene_, movement_, placed.tracer, receivers, *bounds);
    spent += Clock::now() - start;
    analysisMs_ += std::chrono::duration<double, std::milli>(spent).count();
    return {*bounds, std::move(analysis)};
}

}  // namespace penumbra
