#include "core/effects/movement.hpp"

#include <fmt/format.h>

namespace penumbra {

Movement Movement::of(const Scene& scene) {
    Movement movement;
    const SceneFrame first = scene.frame(0);
    const auto undecided = [&] {
        return (scene.movingLight && !movement.light) ||
               (scene.movingCasters && !movement.casters) ||
               (scene.movingCamera && !movement.camera);
    };
    for (int i = 1; i < scene.frameCount() && undecided(); ++i) {
        const SceneFrame now = scene.frame(i);
        if (movement.light == 0 && now.light != first.light) movement.light = i;
        // Equal poses share their geometry.
        if (movement.casters == 0 && now.geometry != first.geometry) movement.casters = i;
        if (movement.camera == 0 && !(now.camera == first.camera)) movement.camera = i;
    }
    return movement;
}

void Movement::tell(EffectFindings& findings) const {
    const auto say = [&](Effect effect, int firstFrame, const char* what) {
        findings[effect] = {
            firstFrame > 0,
            firstFrame > 0
                ? fmt::format("{} in frame {} is another than in frame 0", what, firstFrame)
                : fmt::format("{} is the same in all frames", what)};
    };
    say(Effect::moving_light, light, "the light");
    say(Effect::moving_casters, casters, "the geometry");
    say(Effect::moving_camera, camera, "the camera");
}

}  // namespace penumbra
