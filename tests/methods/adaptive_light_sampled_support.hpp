#pragma once

#include <string>

#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra::test::adaptive {

inline const std::string kId = "adaptive_light_sampled";

class AdaptiveLightSampled : public GlTest {};

inline Assignments with(Assignments settings, const Assignments& more) {
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
}

/// An image and what the row would say of it.
struct Outcome {
    Visibility image;
    WorkCounters counters;
    int maps = 0;  ///< without the centre's
};

inline Outcome outcome(const TestFrame& frame, const Assignments& settings,
                       const EffectChoice& effects = {}) {
    const auto method = findMethod(kId).make();
    for (const auto& [parameter, value] : settings) method->set(kId, parameter, value);
    const Plan plan = planFor(effects, frame.calledFor(), method->traits().simulates);
    method->prepare(frame->scene, plan);
    const TextureTarget target(frame->width(), frame->height());
    target.poison();
    method->build(*frame, plan);
    method->shade(*frame, plan, target);
    gl::checkErrors(method->text());
    const WorkCounters counters = method->counters();
    return {target.read(), counters, std::stoi(counters.message)};
}

inline int mapsOf(const TestFrame& frame, const Assignments& settings) {
    return outcome(frame, settings).maps;
}

/// Every pixel compared and every map read, from the light's very corners on.
inline const Assignments kThorough = {{"stride", "1"},
                                      {"skip_decided", "false"},
                                      {"centre_test", "false"},
                                      {"rim_depth", "-1"},
                                      {"map_size", "128"}};

/// The paper's own algorithm for two-dimensional lights (DirectX 10, section 4.2).
inline const Assignments kPaper = with(kThorough, {{"compare", "relative"},
                                                   {"gamma", "0.01"},
                                                   {"criterion", "map_texels"},
                                                   {"pairs", "diagonals"},
                                                   {"weights", "local_depth"},
                                                   {"count_by", "queries"},
                                                   {"epsilon", "0.005"}});

/// A floor under a light of 0.8 x 0.8 metres, 2 metres above; casters are added.
struct Room {
    Shape shape;
    AreaLight light = lightAbove(2.0, 0.8, 0.8);
    Room() { shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0); }
    TestFrame frame(int size = 96) const {
        return {{shape.geometry(), light},
                planeGBuffer(size, size, {-0.8, -0.8, 0}, {1.6, 0, 0}, {0, 1.6, 0}, light)};
    }
};

inline Room box() {
    Room room;
    room.shape.box({-0.3, -0.25, 0.4}, {0.2, 0.3, 0.7});
    return room;
}

}  // namespace penumbra::test::adaptive
