#include "harness/study/study_frame.hpp"

#include <utility>

namespace penumbra {

StudyFrame::StudyFrame(std::shared_ptr<const Scene> scene, int index, int width, int height,
                       std::uint32_t seed)
    : staged_(std::move(scene), index, width, height, seed), target_(width, height) {}

Row StudyFrame::warmUp(SettingRun& run, const EffectChoice& effects) const {
    const Frame& frame = staged_.frame;
    Row row;
    row.scene = frame.scene.id;
    row.frame = frame.index;
    row.method = run.setting().method;
    row.setting = run.setting().name;
    row.params = run.setting().params;
    row.width = frame.width();
    row.height = frame.height();
    const EffectSet canSimulate = run.setting().make()->traits().simulates;
    run.warmUp(frame, planFor(effects, staged_.analysis.calledFor(), canSimulate), false, target_,
               row);
    return row;
}

const Reference& StudyFrame::reference(const TruthOptions& options) const {
    if (!reference_) {
        const Frame& frame = staged_.frame;
        reference_ = std::make_unique<const Reference>(obtainReference(frame.scene, frame.index,
                                                                       frame.tracer, frame.gbuffer,
                                                                       frame.light, options)
                                                           .reference);
    }
    return *reference_;
}

}  // namespace penumbra
