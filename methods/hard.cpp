// Hard shadows: one shadow map from the light's centre, one nearest comparison per pixel
// (METHODS.md 1). The light's extent is ignored, so every penumbra is wrong by up to one half; it
// is the baseline for cost and the limit that every soft method must reach as the light shrinks.
// Edges show the map's texels.
//
// The map holds only the parts that cast, and without self_shadow nothing is biased. Thin and
// layered casters are one texel like any other: nothing to save. Pixels are one comparison each,
// which is less than any test that could spare it.

#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class Hard : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 1024, 16, 16384, "texels", "side of the shadow map"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all() - EffectSet{Effect::penumbra}}; }

    std::vector<Assignments> ladder() const override {
        return {{{"map_size", "256"}},
                {{"map_size", "512"}},
                {{"map_size", "1024"}},
                {{"map_size", "2048"}},
                {{"map_size", "4096"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        depth_ = DepthPass(plan, bias_.compared(plan, 1));
        program_ = gl::Program::graphics("hard.glsl", MapBias::defines(plan));
    }

    void build(const Frame& frame, const Plan&) override {
        depth_.render(frame, LightView::fit(frame, glm::dvec2(0.0), mapSize_), mapSize_);
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        const gl::DebugGroup group("hard: compare");
        program_.use();
        depth_.bind(program_, 0);
        bias_.set(program_, plan);
        target.draw(program_, frame.gbufferTextures);
    }

    WorkCounters counters() const override {
        return {depth_.map().layers(), depth_.texels(), depth_.map().mebibytes(), ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()}};
    }

  private:
    DepthPass depth_;
    gl::Program program_;
};

const Register<Hard> entry{"hard", "Hard shadow map", "Williams 1978"};

}  // namespace
}  // namespace penumbra
