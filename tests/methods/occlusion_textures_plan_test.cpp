// What the plan and the pixels do not call for costs occlusion_textures nothing and changes
// nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "core/gl/work_counter.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/render.hpp"

namespace penumbra {
namespace {

using namespace test;

class OcclusionTexturesPlan : public GlTest {};

constexpr const char* kId = "occlusion_textures";

/// A method prepared for a plan, an image of it and what that cost.
struct Measured {
    Visibility image;
    gl::Work work;
    WorkCounters counters;

    Measured(const TestFrame& frame, const std::string& effects,
             const Assignments& assignments = {}) {
        const std::unique_ptr<ShadowMethod> method = findMethod(kId).make();
        for (const auto& [parameter, value] : assignments) method->set(kId, parameter, value);
        const Plan plan =
            planFor(EffectChoice::parse(effects), frame.calledFor(), method->traits().simulates);
        method->prepare(frame->scene, plan);
        const TextureTarget target(frame->width(), frame->height());
        target.poison();
        gl::WorkCounter counter;
        method->build(*frame, plan);
        method->shade(*frame, plan, target);
        work = counter.stop();
        counters = method->counters();
        image = target.read();
        gl::checkErrors(method->text());
    }
};

/// Pixels whose answers are not the same. What tiles answer is exactly 0 or 1; the others' kernels
/// are looked up by the same arithmetic, where compilers may fuse other operations: some last
/// places.
int differing(const TestFrame& frame, const Visibility& a, const Visibility& b) {
    return violations(frame, a, [&](float v, std::size_t i) { return std::abs(v - b[i]) < 1e-5f; });
}

/// Share of pixels that are shaded though tiles are asked: all the rest is the same under both
/// plans, for the answers are written over every pixel.
double shadedShare(const TestFrame& frame, const Measured& all, const Measured& automatic) {
    const double tiles = std::ceil(frame->width() / 4.0) * std::ceil(frame->height() / 4.0);
    return (static_cast<double>(automatic.work.fragments) -
            static_cast<double>(all.work.fragments) - tiles) /
           (frame->width() * frame->height());
}

/// Balls, a leaning sheet and a floor, from one side; all slices have something.
TestFrame crowd(double lightM, bool tilted = false) {
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec2 at(std::sin(2.4 * i) * 0.08 * i, std::cos(2.4 * i) * 0.08 * i);
        shape.sphere({at, 0.1 + 0.09 * i}, 0.12, 12);
    }
    shape.quad({-1.0, 0.6, 0.0}, {1.0, 0.6, 0.0}, {1.0, 1.2, 0.8}, {-1.0, 1.2, 0.8});
    World world{shape.geometry(), lightAbove(3.0, lightM, 0.5 * lightM)};
    if (tilted) {
        const glm::dvec3 towards = glm::normalize(glm::dvec3(0.3, 0.5, -3.0));
        world.light.centre = -3.2 * towards;
        world.light.axisU = glm::normalize(glm::cross(glm::dvec3(0.0, 1.0, 0.0), towards));
        world.light.axisV = glm::cross(world.light.axisU, towards);
        if (glm::dot(glm::cross(world.light.axisU, world.light.axisV), towards) < 0.0)
            world.light.axisV = -world.light.axisV;
    }
    world.camera = lookingAt({1.5, -2.5, 2.5}, {0.0, 0.1, 0.2});
    return {world, 126};  // no multiple of a tile
}

/// Plates over points that are not geometry, so that nothing but the plates casts.
TestFrame plates(const std::vector<double>& heightsM) {
    Shape shape;
    for (const double heightM : heightsM) shape.rectangle({-0.3, -0.3}, {0.3, 0.3}, heightM);
    const AreaLight light = lightAbove(4.0, 0.4, 0.4);
    return {{shape.geometry(), light},
            planeGBuffer(128, 128, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, light)};
}

TEST_F(OcclusionTexturesPlan, TilesAnswerWhatPixelsWould) {
    for (const double lightM : {0.05, 0.3, 0.9})
        for (const bool tilted : {false, true}) {
            const TestFrame frame = crowd(lightM, tilted);
            const Measured all(frame, "all"), automatic(frame, "auto");
            EXPECT_EQ(differing(frame, automatic.image, all.image), 0) << lightM << tilted;
            // Both kinds of tiles must be there, or this shows nothing.
            EXPECT_GT(shadedShare(frame, all, automatic), 0.1) << lightM << tilted;
            EXPECT_LT(shadedShare(frame, all, automatic), 0.9) << lightM << tilted;
        }
}

TEST_F(OcclusionTexturesPlan, TilesAnswerWhatPixelsWouldAtEverySetting) {
    const TestFrame frame = crowd(0.3);
    for (const Assignments& settings :
         {Assignments{{"contact", "none"}, {"combination", "product"}},
          Assignments{{"cells", "1"}, {"slices", "40"}, {"thin_casters", "none"}},
          Assignments{{"map_size", "64"}, {"projection", "orthographic"}, {"cells", "1"}},
          Assignments{{"snap", "false"}, {"bias", "16"}, {"combination", "max"}}})
        EXPECT_EQ(differing(frame, Measured(frame, "auto", settings).image,
                            Measured(frame, "all", settings).image),
                  0)
            << settings[0].first;
}

TEST_F(OcclusionTexturesPlan, LitAndFullyDarkTilesAreNotShaded) {
    // The plate's shadow is 0.8 m wide, its penumbra 0.13 m: with a tile, 0.125 m, to both sides
    // 0.38 m times 3.2 m of 16 square metres.
    const TestFrame frame = plates({1.0});
    const Measured all(frame, "all"), automatic(frame, "auto");
    EXPECT_LT(shadedShare(frame, all, automatic), 0.08);
    EXPECT_EQ(differing(frame, automatic.image, all.image), 0);
    EXPECT_NE(unequal(frame, automatic.image, 0.0f), 128 * 128) << "there should be an umbra";
    EXPECT_NE(unequal(frame, automatic.image, 1.0f), 0) << "and not only light";
}

TEST_F(OcclusionTexturesPlan, SlicesWithoutCastersDoNotExist) {
    const TestFrame one = plates({1.0}), many = crowd(0.3);
    const Measured few(one, "auto", {{"contact", "none"}}),
        all(many, "auto", {{"contact", "none"}});
    constexpr double kTexels = 512.0 * 512.0;
    // One plate on a boundary may be drawn into the slices to both of its sides.
    EXPECT_LE(few.counters.lightTexels, 2.0 * kTexels);
    EXPECT_GE(all.counters.lightTexels, 12.0 * kTexels);
    EXPECT_LT(few.counters.textureMib, 0.6 * all.counters.textureMib);
}

TEST_F(OcclusionTexturesPlan, WithoutSelfShadowClearCastersNeedNoMap) {
    struct Case {
        std::vector<double> heightsM;
        int maps;
    };
    // Slices are 0.09 and 0.18 m thick: many of them above the receivers, and within the last.
    for (const Case& c : {Case{{1.5}, 1}, Case{{3.0, 0.1}, 2}}) {
        const TestFrame frame = plates(c.heightsM);
        const Assignments settings = {{"placement", "uniform"}};
        const Measured all(frame, "all", settings),
            needed(frame, "penumbra,thin_casters,layered_casters", settings);
        EXPECT_EQ(all.counters.maps, 2) << c.maps;
        EXPECT_EQ(needed.counters.maps, c.maps);
        EXPECT_EQ(differing(frame, needed.image, all.image), 0) << c.maps;
    }
}

}  // namespace
}  // namespace penumbra
