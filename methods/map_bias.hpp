#pragma once

#include <string>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/gl/program.hpp"
#include "core/parameter/parameter.hpp"
#include "core/passes/depth_pass.hpp"

namespace penumbra {

/// The parameter `bias` of every method whose receivers are compared with a map of nearM / z by
/// litAt of shaders/common/light_view.glsl. Where the plan has no self_shadow no caster comes near
/// a receiver and there is none: neither uniform nor arithmetic.
class MapBias : public FloatParameter {
  public:
    explicit MapBias(Parameters* owner)
        : FloatParameter(owner, "bias", 0.5, 0.0, 64.0, "texels",
                         "how far towards the light a receiver is moved before the comparison, in "
                         "texel footprints at its depth") {}

    /// What a program that includes light_view.glsl is compiled with besides `others`.
    static std::vector<std::string> defines(const Plan& plan,
                                            std::vector<std::string> others = {}) {
        if (!plan.has(Effect::self_shadow)) others.emplace_back("NO_BIAS");
        return others;
    }
    /// Texels, 0 where the plan has none.
    float texels(const Plan& plan) const {
        return plan.has(Effect::self_shadow) ? static_cast<float>(*this) : 0.0f;
    }
    /// What a map holds that receivers are compared with texel by texel, with `kernel` x `kernel`
    /// of them. Too little bias shows a surface its own shadow, which is not there without the
    /// surface.
    MapParts compared(const Plan& plan, int kernel) const {
        return plan.everyPixel                              ? MapParts::all
               : !plan.has(Effect::self_shadow)             ? MapParts::casting
               : *this >= 0.5f * static_cast<float>(kernel) ? MapParts::compared
                                                            : MapParts::all;
    }
    /// The same of a map that a filter adds up, which may find what no comparison does.
    static MapParts filtered(const Plan& plan) {
        return plan.has(Effect::self_shadow) ? MapParts::all : MapParts::casting;
    }
    /// Sets its uniform on `program` (in use), where it has one.
    void set(const gl::Program& program, const Plan& plan) const {
        if (plan.has(Effect::self_shadow)) program.set("biasTexels", texels(plan));
    }
};

}  // namespace penumbra
