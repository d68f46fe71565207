// Percentage-closer filtering: the hard comparison averaged over a fixed kernel around the receiver
// (Reeves, Salesin, Cook 1987; METHODS.md 2). Every tap compares against the receiver's own plane
// followed to that tap (receiver-plane depth bias), so wide kernels do not shade slopes. The
// penumbra has one width whatever the distances, so it is too wide at contacts and too narrow far
// from the caster; kernels wider than a caster's detail step over it, and on concave or twisted
// surfaces a kernel wider than a facet finds the next one above its plane and shades it (spinner).

#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class Pcf : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 1024, 16, 16384, "texels", "side of the shadow map"};
    ChoiceParameter pattern_{
        this,
        "pattern",
        {"grid", "vogel"},
        "taps at the cell centres of a k x k grid, k^2 the greatest square not "
        "above taps, over the kernel's rectangle; or on its inscribed Vogel disc"};
    IntParameter taps_{this, "taps", 49, 1, 1024, "", "comparisons per pixel"};
    FloatParameter kernel_{this,
                           "kernel",
                           0.25,
                           0.0,
                           4.0,
                           "light sizes",
                           "kernel width at the receiver over the light's width, each axis apart: "
                           "0.25 fits casters a fifth of the way up from receiver to light"};
    FloatParameter bias_{this,
                         "bias",
                         0.5,
                         0.0,
                         64.0,
                         "texels",
                         "how far towards the light a receiver is moved before the comparison, in "
                         "texel footprints at its depth"};

  public:
    Traits traits() const override {
        return {{Effect::penumbra, Effect::self_shadow, Effect::thin_casters,
                 Effect::layered_casters, Effect::alpha_mask, Effect::moving_light,
                 Effect::moving_casters, Effect::moving_camera}};
    }

    std::vector<Assignments> ladder() const override {
        return {{{"taps", "9"}, {"map_size", "512"}},
                {{"taps", "25"}, {"map_size", "1024"}},
                {{"taps", "49"}, {"map_size", "1024"}},
                {{"taps", "121"}, {"map_size", "2048"}},
                {{"taps", "289"}, {"map_size", "2048"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        depth_ = DepthPass(plan.has(Effect::alpha_mask));
        program_ = gl::Program::graphics("pcf.glsl", {!plan.has(Effect::penumbra) ? "KERNEL_POINT"
                                                      : pattern_.is("grid")       ? "KERNEL_GRID"
                                                                            : "KERNEL_VOGEL"});
    }

    void build(const Frame& frame, const Plan&) override {
        const glm::dvec2 halfKernelM = kernelHalf(frame.light);
        depth_.render(frame, LightView::fit(frame, halfKernelM, mapSize_), mapSize_);
    }

    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        const gl::DebugGroup group("pcf: filter");
        program_.use();
        depth_.bind(program_, 0);
        program_.set("biasTexels", static_cast<float>(bias_));
        program_.set("kernelHalfM", glm::vec2(kernelHalf(frame.light)));
        program_.set(*this);
        target.draw(program_, frame.gbufferTextures);
    }

    WorkCounters counters() const override {
        return {depth_.map().layers(), depth_.texels(), depth_.map().mebibytes(), ""};
    }

  private:
    glm::dvec2 kernelHalf(const AreaLight& light) const {
        return static_cast<double>(kernel_) * glm::dvec2(light.halfU, light.halfV);
    }

    DepthPass depth_;
    gl::Program program_;
};

const Register<Pcf> entry{"pcf", "Percentage-closer filtering", "Reeves, Salesin, Cook 1987"};

}  // namespace
}  // namespace penumbra
