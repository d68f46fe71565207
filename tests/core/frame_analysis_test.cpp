// Each effect: a scene that calls for it and, as near to it as can be, one that provably does not.
#include "core/analysis/frame_analysis.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>

#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using test::joined;
using test::planeGBuffer;
using test::World;

using Shapes = std::vector<std::pair<Shape, int>>;

Shape box(const glm::dvec3& lo, const glm::dvec3& hi) {
    Shape shape;
    shape.box(lo, hi);
    return shape;
}

Shape sheet(glm::dvec2 lo, glm::dvec2 hi, double z) {
    Shape shape;
    shape.rectangle(lo, hi, z);
    return shape;
}

/// 4 m x 4 m around the origin.
const Shape kPlate = sheet({-2, -2}, {2, 2}, 0.0);

/// A light 3 m above the plate, 0.4 m wide: the view of the plate is 4/3 of the distance wide, so
/// that casters must keep 3 * 4/3 / 16 = 0.25 m off it.
World world(const Shapes& casters, double lightM = 0.4) {
    Shapes shapes = {{kPlate, 0}};
    shapes.insert(shapes.end(), casters.begin(), casters.end());
    World w{joined(shapes), test::lightAbove(3.0, lightM, lightM)};
    w.materials.resize(2);
    return w;
}

/// What is seen: the plate between `lo` and `hi`.
GBuffer plateSeen(const World& w, glm::dvec2 lo = {-2, -2}, glm::dvec2 hi = {2, 2}) {
    return planeGBuffer(64, 64, {lo, 0.0}, {hi.x - lo.x, 0, 0}, {0, hi.y - lo.y, 0}, w.light);
}

FrameAnalysis analyse(const World& w, const GBuffer& gbuffer) {
    const test::MemoryScene scene(w);
    const Tracer tracer(w.geometry, scene.materials, scene.images);
    return analyseFrame(scene, tracer, w.light, gbuffer, boundLight(w.light, gbuffer, *w.geometry));
}

FrameAnalysis analyse(const World& w) {
    return analyse(w, plateSeen(w));
}

void expectEvidence(const FrameAnalysis& analysis, Effect effect, bool calledFor,
                    const std::string& words) {
    const EffectFinding& finding = analysis.findings[effect];
    EXPECT_EQ(finding.calledFor, calledFor) << finding.evidence;
    EXPECT_NE(finding.evidence.find(words), std::string::npos) << finding.evidence;
}

const Shape kHigh = box({-0.3, -0.3, 1.0}, {0.3, 0.3, 1.2});

TEST(FrameAnalysis, ABoxInTheAirCallsForPenumbraeOnly) {
    const FrameAnalysis analysis = analyse(world({{kHigh, 0}}));
    EXPECT_EQ(analysis.calledFor(), EffectSet{Effect::penumbra});
    const std::vector<PartFacts>& parts = analysis.casterFacts.parts;
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_TRUE(parts[0].thin && !parts[0].casts) << "the floor";
    EXPECT_TRUE(!parts[1].thin && parts[1].casts) << "the box";
    expectEvidence(analysis, Effect::penumbra, true, "of 4096 sampled light rays are blocked");
    expectEvidence(analysis, Effect::self_shadow, false, "nothing comes near");
    expectEvidence(analysis, Effect::thin_casters, false, "all 12 caster triangles");
    expectEvidence(analysis, Effect::layered_casters, false, "no light ray meets two");
    expectEvidence(analysis, Effect::alpha_mask, false, "no material is masked");
    expectEvidence(analysis, Effect::moving_light, false, "the same in all frames");
}

TEST(FrameAnalysis, AFloorThatThingsStandOnShadowsNothing) {
    const FrameAnalysis analysis = analyse(world({{box({-0.3, -0.3, 0}, {0.3, 0.3, 0.5}), 0}}));
    EXPECT_TRUE(analysis.calledFor().has(Effect::self_shadow));
    EXPECT_GT(analysis.casterFacts.besideTangent, 0.0);
    EXPECT_FALSE(analysis.casterFacts.parts[0].inTheWay) << "the floor";
    EXPECT_TRUE(analysis.casterFacts.parts[1].inTheWay) << "the box";
}

TEST(FrameAnalysis, WhereNothingLiesBetweenNothingIsCalledFor) {
    // Below the plate, behind the light and beside all rays.
    const FrameAnalysis analysis = analyse(world({{box({-1, -1, -1}, {1, 1, -0.5}), 0},
                                                  {box({-1, -1, 3.1}, {1, 1, 3.5}), 0},
                                                  {box({2.3, -1, 0.5}, {2.6, 1, 1.0}), 0}}));
    EXPECT_TRUE(analysis.calledFor().empty()) << analysis.calledFor().text();
    for (const PartFacts& facts : analysis.casterFacts.parts) EXPECT_FALSE(facts.casts);
    expectEvidence(analysis, Effect::penumbra, false, "nothing lies between");
}

TEST(FrameAnalysis, APointLightHasNoPenumbra) {
    const FrameAnalysis analysis = analyse(world({{kHigh, 0}}, 0.0));
    expectEvidence(analysis, Effect::penumbra, false, "the light is a point");
    EXPECT_TRUE(analysis.calledFor().empty());
}

TEST(FrameAnalysis, AHorizonIsAPenumbraToo) {
    // A wall's face from which half of the light is behind it, and nothing else.
    const World w = world({});
    const GBuffer face = planeGBuffer(32, 32, {0, -0.5, 0.1}, {0, 1, 0}, {0, 0, 1}, w.light);
    ASSERT_GT(face.count(PixelClass::horizon), 0u);
    expectEvidence(analyse(w, face), Effect::penumbra, true, "above their horizon");
}

TEST(FrameAnalysis, ACasterTooSmallForSamplesIsNotMissed) {
    // 1 mm in 4 m: of 4096 rays none is likely to meet it.
    const FrameAnalysis analysis =
        analyse(world({{box({0.5, 0.5, 1.0}, {0.501, 0.501, 1.001}), 0}}));
    EXPECT_EQ(analysis.calledFor(), EffectSet{Effect::penumbra});
    expectEvidence(analysis, Effect::penumbra, true, "could not be excluded");
}

TEST(FrameAnalysis, PointsOnCastersCallForSelfShadow) {
    const World w = world({{kHigh, 0}});
    const GBuffer top = planeGBuffer(64, 64, {-0.3, -0.3, 1.2}, {0.6, 0, 0}, {0, 0.6, 0}, w.light);
    expectEvidence(analyse(w, test::stacked({plateSeen(w), top})), Effect::self_shadow, true,
                   "50 % of 1024 sampled points lie on casters");
    // The box alone: its lid looks at the light, and nothing is in between.
    EXPECT_FALSE(analyse(w, top).calledFor().has(Effect::self_shadow));
}

TEST(FrameAnalysis, CastersMustKeepClearOfReceivers) {
    const auto above = [](double zM) {
        return analyse(world({{box({-0.3, -0.3, zM}, {0.3, 0.3, zM + 0.1}), 0}}));
    };
    EXPECT_TRUE(above(0.0).calledFor().has(Effect::self_shadow));
    expectEvidence(above(0.24), Effect::self_shadow, true, "could not be excluded");
    EXPECT_FALSE(above(0.26).calledFor().has(Effect::self_shadow));
}

TEST(FrameAnalysis, ARoomsWallsBlockNoRayButAreInTheWayOfFilters) {
    // Floor and wall share an edge; light and points are on one side of both. A filter at the edge
    // finds the wall above the floor's plane.
    Shape wall;
    wall.quad({2, -2, 0}, {2, 2, 0}, {2, 2, 2}, {2, -2, 2});
    const World w = world({{wall, 0}});
    const GBuffer onWall = planeGBuffer(64, 64, {2, -2, 0}, {0, 0, 2}, {0, 4, 0}, w.light);
    ASSERT_GT(onWall.count(PixelClass::scored), 0u);
    const FrameAnalysis analysis = analyse(w, test::stacked({plateSeen(w), onWall}));
    EXPECT_EQ(analysis.calledFor(), (EffectSet{Effect::penumbra, Effect::self_shadow}));
    for (const PartFacts& facts : analysis.casterFacts.parts) EXPECT_FALSE(facts.casts);
}

TEST(FrameAnalysis, OpenSurfacesAreThinWhereTheyCast) {
    expectEvidence(analyse(world({{kHigh, 0}, {sheet({0.5, 0.5}, {0.8, 0.8}, 1.0), 0}})),
                   Effect::thin_casters, true, "2 of 14 caster triangles");
    // So is the plate, which casts nothing, and so is what lies beside all rays.
    EXPECT_FALSE(analyse(world({{kHigh, 0}, {sheet({2.3, 0.5}, {2.6, 0.8}, 1.0), 0}}))
                     .calledFor()
                     .has(Effect::thin_casters));
}

TEST(FrameAnalysis, TwoCastersOnOneRayAreLayers) {
    const Shape other = box({-0.3, -0.3, 1.5}, {0.3, 0.3, 1.6});
    expectEvidence(analyse(world({{kHigh, 0}, {other, 0}})), Effect::layered_casters, true,
                   "sampled light rays meet two or more casters");
    // Side by side they are none, in one part or two.
    const Shape beside = box({0.9, -0.3, 1.0}, {1.4, 0.3, 1.2});
    EXPECT_EQ(analyse(world({{kHigh, 0}, {beside, 0}})).calledFor(), EffectSet{Effect::penumbra});
    Shape both = kHigh;
    both.box({0.9, -0.3, 1.0}, {1.4, 0.3, 1.2});
    EXPECT_EQ(analyse(world({{both, 0}})).calledFor(), EffectSet{Effect::penumbra});
}

TEST(FrameAnalysis, LayersThatSamplesMissAreNotExcluded) {
    // Needles of 1 mm over one another.
    expectEvidence(analyse(world({{box({0.5, 0.5, 1.0}, {0.501, 0.501, 1.001}), 0},
                                  {box({0.45, 0.45, 1.2}, {0.451, 0.451, 1.201}), 0}})),
                   Effect::layered_casters, true, "could not be excluded");
}

TEST(FrameAnalysis, ABodyThatIsNotConvexMayBeMetTwice) {
    Shape bent;
    bent.quad({-0.3, -0.3, 1.0}, {0, -0.3, 1.1}, {0, 0.3, 1.1}, {-0.3, 0.3, 1.0});
    bent.quad({0, -0.3, 1.1}, {0.3, -0.3, 1.0}, {0.3, 0.3, 1.0}, {0, 0.3, 1.1});
    expectEvidence(analyse(world({{bent, 0}})), Effect::layered_casters, true,
                   "could not be excluded");
}

/// The plate and a masked sheet of one texture with this alpha in one of four texels.
World masked(std::uint8_t alpha, double x = -0.5) {
    World w = world({{sheet({x, -0.5}, {x + 1, 0.5}, 1.0), 1}});
    w.materials[1].masked = true;
    w.materials[1].name = "leaf";
    w.materials[1].baseColorTexture = 0;
    TextureImage image;
    image.width = image.height = 2;
    image.rgba.assign(16, 255);
    image.rgba[3] = alpha;
    w.images = {image};
    return w;
}

TEST(FrameAnalysis, AlphaMattersWhereItCutsACasterOut) {
    expectEvidence(analyse(masked(0)), Effect::alpha_mask, true,
                   "25 % of the texels of a caster's material 'leaf' are below its cutoff");
    // A cutoff of 1/2 is 127.5.
    EXPECT_TRUE(analyse(masked(127)).calledFor().has(Effect::alpha_mask));
    expectEvidence(analyse(masked(128)), Effect::alpha_mask, false,
                   "no masked texture has a texel below its cutoff");
    expectEvidence(analyse(masked(0, 2.3)), Effect::alpha_mask, false, "nothing lies between");
}

TEST(FrameAnalysis, ACutOutSolidIsThin) {
    World w = masked(0);
    w.geometry = joined({{kPlate, 0}, {kHigh, 1}});
    EXPECT_TRUE(analyse(w).calledFor().has(Effect::thin_casters));
    w.images[0].rgba.assign(16, 255);
    EXPECT_FALSE(analyse(w).calledFor().has(Effect::thin_casters));
}

TEST(FrameAnalysis, OfWhatIsNotFiniteNothingIsExcluded) {
    World w = world({{kHigh, 0}});
    auto broken = std::make_shared<Geometry>(*w.geometry);
    broken->positions.back().x = std::numeric_limits<float>::infinity();
    w.geometry = broken;
    expectEvidence(analyse(w), Effect::self_shadow, true, "not finite");
}

TEST(FrameAnalysis, DependsOnWhatIsSeen) {
    // From a corner of the plate no ray passes the box.
    const World w = world({{kHigh, 0}});
    EXPECT_TRUE(analyse(w, plateSeen(w, {1.6, 1.6}, {2, 2})).calledFor().empty());
}

TEST(FrameAnalysis, IsTheSameOnAnyNumberOfThreads) {
    Shapes many;
    for (int i = 0; i < 40; ++i) {
        const double x = -1.8 + 0.09 * i, y = -1.5 + 0.7 * (i % 5);
        many.push_back({box({x, y, 0.4 + 0.03 * i}, {x + 0.1, y + 0.1, 0.5 + 0.03 * i}), 0});
    }
    const World w = world(many);
    const GBuffer gbuffer = plateSeen(w);
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return analyse(w, gbuffer);
    };
    const FrameAnalysis one = onThreads(1), four = onThreads(4);
    EXPECT_EQ(one.findings, four.findings);
    EXPECT_EQ(one.casterFacts, four.casterFacts);
}

/// Frames whose light, geometry and camera are given.
class Frames final : public Scene {
  public:
    explicit Frames(std::vector<SceneFrame> frames) : frames_(std::move(frames)) {
        movingLight = movingCasters = movingCamera = true;  // there are tracks
    }
    int frameCount() const override { return static_cast<int>(frames_.size()); }
    SceneFrame frame(int i) const override { return frames_.at(static_cast<std::size_t>(i)); }

  private:
    std::vector<SceneFrame> frames_;
};

TEST(Movement, AConstantTrackMovesNothing) {
    const auto geometry = kPlate.geometry();
    const SceneFrame still{0.0, geometry, test::lightAbove(3, 1, 1), {}};
    SceneFrame lit = still, posed = still, seen = still;
    lit.light.halfU = 0.25;
    posed.geometry = kHigh.geometry();
    seen.camera.position.x += 1.0;
    EXPECT_EQ(Movement::of(Frames({still, still, still})), Movement());
    EXPECT_EQ(Movement::of(Frames({still, still, lit})), (Movement{2, 0, 0}));
    EXPECT_EQ(Movement::of(Frames({still, posed, still})), (Movement{0, 1, 0}));
    EXPECT_EQ(Movement::of(Frames({still, seen, lit})), (Movement{2, 0, 1}));

    EffectFindings findings;
    Movement{2, 0, 1}.tell(findings);
    EXPECT_TRUE(findings[Effect::moving_light].calledFor);
    EXPECT_EQ(findings[Effect::moving_light].evidence,
              "the light in frame 2 is another than in frame 0");
    EXPECT_FALSE(findings[Effect::moving_casters].calledFor);
    EXPECT_TRUE(findings[Effect::moving_camera].calledFor);
}

}  // namespace
}  // namespace penumbra
