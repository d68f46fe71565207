#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/frame/slice_view.hpp"
#include "core/scene/scene.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/render.hpp"

namespace penumbra {
namespace {

using namespace test;

class OcclusionTexturesCases : public GlTest {};

constexpr const char* kId = "occlusion_textures";

// --- one texel's translation --------------------------------------------------------------------

/// A caster of some rectangles in z = 2 under a light in z = 4, moved by `texels` texels of an
/// orthographic view 256 texels wide along x, and a row of receivers on the floor that are as far
/// apart as a texel's shadow moves: an image that follows the caster shifts by that many pixels.
struct Moving {
    static constexpr int kPixels = 100, kMapSize = 256;
    static constexpr double kLightM = 4.0, kCasterM = 2.0, kReachM = 2.0;

    Assignments settings(const char* prefilter) const {
        return {{"prefilter", prefilter}, {"projection", "orthographic"},
                {"map_size", "256"},      {"cells", "1"},
                {"contact", "none"},      {"thin_casters", "none"}};
    }
    AreaLight light() const { return lightAbove(kLightM, 0.4, 0.4); }
    /// What the window is fitted to.
    GBuffer rim() const {
        return planeGBuffer(kPixels, 2, {-kReachM, -kReachM, 0}, {2 * kReachM, 0, 0},
                            {0, 2 * kReachM, 0}, light());
    }
    static Shape caster(double texelM, double texels) {
        Shape shape;
        // Edges between texels' centres: nothing is decided by rounding.
        for (const auto& [x, y, width, height] : {std::array{-31.0, -20.0, 3.0, 40.0},
                                                  {-20.0, -9.0, 17.0, 19.0},
                                                  {5.0, -22.0, 9.0, 31.0}})
            shape.rectangle(glm::dvec2(x + texels, y) * texelM,
                            glm::dvec2(x + texels + width, y + height) * texelM, kCasterM);
        return shape;
    }
    Visibility operator()(std::optional<Renderer>& renderer, const char* prefilter,
                          int texels) const {
        const TestFrame rimFrame({caster(0.01, 0.0).geometry(), light()}, rim());
        const SliceView view =
            SliceView::fit(*rimFrame, {.mapSize = kMapSize, .orthographic = true});
        const double texelM = 1.0 / (view.scale.x * kMapSize);
        // The light's centre throws what is half way up twice as far.
        const double pitchM = 2.0 * texelM, halfM = 0.5 * kPixels * pitchM;
        const TestFrame frame({caster(texelM, texels).geometry(), light()},
                              stacked({planeGBuffer(kPixels, 1, {-halfM, -0.5 * pitchM, 0},
                                                    {2 * halfM, 0, 0}, {0, pitchM, 0}, light()),
                                       rim()}));
        if (!renderer) renderer.emplace(frame, kId, settings(prefilter));
        Visibility image = (*renderer)(frame);
        image.resize(kPixels);
        return image;
    }
    /// Greatest differences between an image moved along and that of the moved caster, for each
    /// move.
    std::vector<float> strays(const char* prefilter, const std::vector<int>& moves) const {
        std::optional<Renderer> renderer;
        const Visibility still = (*this)(renderer, prefilter, 0);
        const auto [least, greatest] = std::ranges::minmax(still);
        EXPECT_LT(least, 0.2f);
        EXPECT_GT(greatest, 0.9f);
        std::vector<float> differences;
        for (const int texels : moves) {
            const Visibility moved = (*this)(renderer, prefilter, texels);
            float most = 0.0f;
            for (int i = 0; i + texels < kPixels; ++i)
                most = std::max(most, std::abs(moved[static_cast<std::size_t>(i + texels)] -
                                               still[static_cast<std::size_t>(i)]));
            differences.push_back(most);
        }
        return differences;
    }
};

TEST_F(OcclusionTexturesCases, ShadowsMoveWithTheCasterTexelByTexel) {
    const Moving moving;
    // Places in the texture are floats of some hundred texels, 2^-17 of one; a kernel is 13 wide.
    for (const float most : moving.strays("sat", {1, 2, 7})) EXPECT_LT(most, 1e-5f);
    // These filter with 8 bits of fraction, whose last bit may fall either way.
    for (const float most : moving.strays("n_buffers", {1, 2, 7})) EXPECT_LT(most, 1e-2f);
    // Kernels of 12.7 texels are looked up in mip levels 2 and 3, whose texels stay where they are.
    // An edge that moves by one of a texel's eight columns changes what is looked up by up to 1/8,
    // a bar's two edges by twice that (0.137 here), and only a whole texel of level 3 shifts them
    // all.
    const std::vector<float> mip = moving.strays("mipmap", {1, 8});
    EXPECT_GT(mip[0], 0.03f);
    EXPECT_LT(mip[0], 0.25f);
    EXPECT_LT(mip[1], 1e-2f);
}

// --- a tilted light -----------------------------------------------------------------------------

/// A rotation about a slanting axis.
glm::dmat3 turned(double angleDeg) {
    const double a = glm::radians(angleDeg);
    const glm::dvec3 axis = glm::normalize(glm::dvec3(1.0, 0.4, -0.3));
    const glm::dmat3 cross(glm::dvec3(0, axis.z, -axis.y), glm::dvec3(-axis.z, 0, axis.x),
                           glm::dvec3(axis.y, -axis.x, 0));
    return glm::dmat3(1.0) + std::sin(a) * cross + (1.0 - std::cos(a)) * cross * cross;
}

/// An oblong light in z = 4 over two casters, all turned about the origin.
TestFrame turnedWorld(double angleDeg) {
    const glm::dmat3 turn = turned(angleDeg);
    AreaLight light = lightAbove(4.0, 1.0, 0.4);
    Shape shape;
    const auto rectangle = [&](glm::dvec2 lo, glm::dvec2 hi, double z) {
        shape.quad(turn * glm::dvec3(lo, z), turn * glm::dvec3(hi.x, lo.y, z),
                   turn * glm::dvec3(hi, z), turn * glm::dvec3(lo.x, hi.y, z));
    };
    rectangle({-0.7, -0.6}, {0.3, 0.4}, 1.0);
    rectangle({-0.1, -0.3}, {0.9, 0.8}, 2.2);
    light.centre = turn * light.centre;
    light.axisU = turn * light.axisU;
    light.axisV = turn * light.axisV;
    return {{shape.geometry(), light},
            planeGBuffer(64, 64, turn * glm::dvec3(-2, -2, 0), turn * glm::dvec3(4, 0, 0),
                         turn * glm::dvec3(0, 4, 0), light)};
}

TEST_F(OcclusionTexturesCases, ATiltedLightIsAnUprightOneInItsOwnSpace) {
    const Visibility upright = render(turnedWorld(0.0), kId);
    for (const double angleDeg : {20.0, 75.0, 180.0}) {
        const TestFrame frame = turnedWorld(angleDeg);
        // Casters' corners are floats: an edge within 1e-7 of a texel's centre falls either way,
        // and the narrowest kernel has some 10 texels a side.
        EXPECT_EQ(
            violations(frame, render(frame, kId),
                       [&](float v, std::size_t i) { return std::abs(v - upright[i]) < 0.02f; }),
            0)
            << angleDeg;
    }
}

TEST_F(OcclusionTexturesCases, ATiltedLightsKernelIsTheLightSeenThroughThePlane) {
    for (const double angleDeg : {0.0, 33.0, 120.0}) {
        const TestFrame frame = turnedWorld(angleDeg);
        for (const bool orthographic : {false, true}) {
            const SliceView view = SliceView::fit(*frame, {.orthographic = orthographic});
            const glm::dmat4 clip(view.clipFromWorld());
            for (const std::size_t i : {0ul, 700ul, 2016ul, 4095ul}) {
                const glm::dvec3 receiver(frame->gbuffer.position[i]);
                const double zM = glm::dot(view.axisZ, receiver - view.centre);
                for (const double planeM : view.planesM) {
                    const glm::dvec2 extent = view.kernelUv(frame->light, zM, planeM);
                    glm::dvec2 lo(1e9), hi(-1e9);
                    for (const glm::dvec3& corner : frame->light.corners()) {
                        const glm::dvec4 p =
                            clip * glm::dvec4(glm::mix(corner, receiver, planeM / zM), 1.0);
                        const glm::dvec2 uv = 0.5 * glm::dvec2(p) / p.w + 0.5;
                        lo = glm::min(lo, uv);
                        hi = glm::max(hi, uv);
                    }
                    // The matrix is of floats.
                    EXPECT_NEAR(hi.x - lo.x, extent.x, 2e-6);
                    EXPECT_NEAR(hi.y - lo.y, extent.y, 2e-6);
                }
            }
        }
    }
}

/// Two plates and a floor that a tilted light's slices cut aslant.
TestFrame aslant() {
    AreaLight light = lightAbove(4.0, 1.0, 1.0);
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.5, 0.6, -4.0));
    light.centre = -4.5 * towards;
    light.axisU = glm::normalize(glm::cross(glm::dvec3(0.0, 1.0, 0.0), towards));
    light.axisV = glm::cross(towards, light.axisU);
    Shape shape;
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, -0.2);
    shape.rectangle({-1.2, -1.0}, {1.2, 1.2}, 0.8);
    shape.rectangle({-1.0, -1.2}, {0.9, 0.9}, 1.6);
    return {{shape.geometry(), light},
            stacked({planeGBuffer(64, 64, {-1.2, -1.0, 0.8}, {2.4, 0, 0}, {0, 2.2, 0}, light),
                     planeGBuffer(64, 64, {-2.0, -2.0, -0.2}, {4.5, 0, 0}, {0, 4.5, 0}, light)})};
}

TEST_F(OcclusionTexturesCases, PlatesThatSlicesCutAslant) {
    const TestFrame frame = aslant();
    const Visibility truth = render(frame, "ray_traced", {{"rays", "256"}}),
                     image = render(frame, kId);
    double squares = 0.0;
    int dark = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        squares += std::pow(static_cast<double>(image[i]) - static_cast<double>(truth[i]), 2.0);
        // Full shadow stays so where the receiver's own slice and the one that fades in share it.
        if (truth[i] > 0.0f) continue;
        ++dark;
        EXPECT_LT(image[i], 0.05f) << i;
    }
    EXPECT_GT(dark, 1000);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(image.size())), 0.03);
}

// --- thin casters, what costs nothing ------------------------------------------------------------

/// Mean V of a scene's pixels that no ray of very many gets light on.
struct Umbra {
    std::shared_ptr<const Scene> scene;
    std::unique_ptr<TestFrame> frame;
    std::vector<std::size_t> pixels;

    Umbra(const std::string& id, int size) : scene(loadScene(id, SceneLibrary::standard())) {
        const SceneFrame moment = scene->frame(0);
        frame = std::make_unique<TestFrame>(World{.geometry = moment.geometry,
                                                  .light = moment.light,
                                                  .camera = moment.camera,
                                                  .materials = scene->materials},
                                            size);
        const Visibility truth = render(*frame, "ray_traced", {{"rays", "256"}});
        for (const std::size_t i : frame->asked())
            if (truth[i] == 0.0f) pixels.push_back(i);
    }
    double lit(const Assignments& settings) const {
        const Visibility image = render(*frame, kId, settings);
        double sum = 0.0;
        for (const std::size_t i : pixels) sum += static_cast<double>(image[i]);
        return sum / static_cast<double>(pixels.size());
    }
};

TEST_F(OcclusionTexturesCases, FillingRemovesTheLeakOfTheButterfly) {
    const Umbra umbra("butterfly", 128);
    ASSERT_GT(umbra.pixels.size(), 500u);
    const auto leak = [&](const char* rule, const char* thin) {
        return umbra.lit({{"combination", rule},
                          {"thin_casters", thin},
                          {"cells", "1"},
                          {"placement", "uniform"}});
    };
    for (const char* rule : {"product", "sum"}) {
        const double open = leak(rule, "none");
        EXPECT_GT(open, 5e-3) << rule;
        for (const char* thin : {"thin", "crossing", "all"})
            EXPECT_LE(leak(rule, thin), 0.1 * open) << rule << ", " << thin;
    }
    // What every rule leaves without the map is not between slices: wings that shadow each other
    // within the receiver's own, which the paper leaves to diffuse illumination.
    const double own = umbra.lit({{"combination", "sum"},
                                  {"thin_casters", "all"},
                                  {"cells", "1"},
                                  {"placement", "uniform"},
                                  {"contact", "none"}});
    EXPECT_GT(own, 10.0 * leak("sum", "all"));
}

TEST_F(OcclusionTexturesCases, EarlyOutsAndTargetsChangeNothing) {
    const TestFrame frame = aslant();
    const Visibility image = render(frame, kId);
    for (const Assignments& same :
         {Assignments{{"early_outs", "false"}}, Assignments{{"targets", "channels"}}}) {
        const Visibility other = render(frame, kId, same);
        // Of a slice without anything to see floats may leave the last place of a share.
        EXPECT_EQ(
            violations(frame, other,
                       [&](float v, std::size_t i) { return std::abs(v - image[i]) < 1e-5f; }),
            0)
            << same[0].first;
    }
}

}  // namespace
}  // namespace penumbra
