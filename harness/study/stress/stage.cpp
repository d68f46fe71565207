#include "harness/study/stress/stage.hpp"

#include "core/gl/context.hpp"
#include "harness/reference/exact.hpp"
#include "harness/run/cells.hpp"

namespace penumbra::stress {

StageFrame::StageFrame(std::shared_ptr<const Scene> scene, int index, int size, std::uint32_t seed)
    : staged_(std::move(scene), index, size, size, seed), asked_(staged_.traced.gbuffer.asked()) {}

const std::vector<float>& StageFrame::exact() const {
    if (exact_.empty()) {
        const Frame& f = staged_.frame;
        exact_ = exactReference(f.tracer, f.scene.materials, f.gbuffer, f.light).visibility;
    }
    return exact_;
}

Stage::Stage(std::shared_ptr<const Scene> scene, int size, std::uint32_t seed) : size_(size) {
    for (int i = 0; i < scene->frameCount(); ++i)
        frames_.push_back(std::make_unique<StageFrame>(scene, i, size, seed));
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
