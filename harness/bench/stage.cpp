#include "harness/bench/stage.hpp"

namespace penumbra::bench {

void needContext() {
    static const auto kContext = gl::Context::create(gl::ContextKind::automatic);
}

namespace {

SceneFrame changed(SceneFrame moment, const std::function<void(AreaLight&)>& change,
                   const std::function<void(Camera&)>& changeCamera) {
    if (change) change(moment.light);
    if (changeCamera) changeCamera(moment.camera);
    return moment;
}

}  // namespace

Stage::Stage(const std::string& id, int width, int height,
             const std::function<void(AreaLight&)>& change,
             const std::function<void(Camera&)>& changeCamera)
    : scene(loadScene(id, SceneLibrary::standard())),
      moment(changed(scene->frame(0), change, changeCamera)),
      tracer(moment.geometry, scene->materials, scene->images),
      gbuffer(renderGBuffer(tracer, moment, *scene, width, height)),
      textures(uploadGBuffer(gbuffer)),
      materials(scene->materials, scene->images),
      geometry(moment.geometry, materials),
      bounds(boundLight(moment.light, gbuffer, *moment.geometry)),
      analysis(analyseFrame(*scene, tracer, moment.light, gbuffer, bounds)),
      frame{*scene, 0,       moment.light, bounds,   moment.camera,        moment.geometry,
            tracer, gbuffer, textures,     geometry, analysis.casterFacts, 1} {}

Stage::Act Stage::act(const std::string& methodId, const Assignments& settings) const {
    Act act{findMethod(methodId).make(), {}};
    for (const auto& [parameter, value] : settings) act.method->set(methodId, parameter, value);
    act.plan = planFor({}, analysis.calledFor(), act.method->traits().simulates);
    act.method->prepare(*scene, act.plan);
    return act;
}

}  // namespace penumbra::bench
