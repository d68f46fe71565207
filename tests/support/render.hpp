#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/gl/context.hpp"
#include "harness/run/visibility_target.hpp"
#include "methods/shadow_method.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra::test {

using Visibility = std::vector<float>;

/// A prepared method, rendering as the harness does: the target is poisoned first and OpenGL errors
/// throw.
class Renderer {
  public:
    Renderer(const TestFrame& frame, const std::string& id, const Assignments& assignments = {},
             const EffectChoice& effects = {})
        : method_(findMethod(id).make()) {
        for (const auto& [parameter, value] : assignments) method_->set(id, parameter, value);
        plan_ = planFor(effects, frame.calledFor(), method_->traits().simulates);
        method_->prepare(frame->scene, plan_);
        gl::checkErrors(id + ": prepare");
    }

    Visibility operator()(const TestFrame& frame) {
        const TextureTarget target(frame->width(), frame->height());
        target.poison();
        method_->build(*frame, plan_);
        method_->shade(*frame, plan_, target);
        gl::checkErrors(method_->text());
        return target.read();
    }

  private:
    std::unique_ptr<ShadowMethod> method_;
    Plan plan_;
};

inline Visibility render(const TestFrame& frame, const std::string& id,
                         const Assignments& assignments = {}, const EffectChoice& effects = {}) {
    return Renderer(frame, id, assignments, effects)(frame);
}

/// How many of the pixels that are asked about fail `holds(visibility, pixel)`; NaN fails any
/// comparison.
template <class Predicate>
int violations(const TestFrame& frame, const Visibility& image, const Predicate& holds) {
    const std::vector<std::size_t> pixels = frame.asked();
    EXPECT_FALSE(pixels.empty()) << "nothing is asked: the test could not fail";
    return static_cast<int>(
        std::ranges::count_if(pixels, [&](std::size_t i) { return !holds(image[i], i); }));
}

inline int outOfRange(const TestFrame& frame, const Visibility& image) {
    return violations(frame, image, [](float v, std::size_t) { return v >= 0.0f && v <= 1.0f; });
}

inline int unequal(const TestFrame& frame, const Visibility& image, float value) {
    return violations(frame, image, [&](float v, std::size_t) { return v == value; });
}

}  // namespace penumbra::test
