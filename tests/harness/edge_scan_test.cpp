#include "harness/metrics/edge_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "harness/metrics/metrics.hpp"
#include "harness/reference/exact.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

constexpr double kWidthM = 0.96;  ///< of half_plane's penumbra, R2.2: 1.6 * 1.5 / (4 - 1.5)

/// One frame of a scene of this tree with its edges.
struct Shown {
    std::shared_ptr<const Scene> scene;
    SceneFrame frame;
    Tracer tracer;
    GBuffer gbuffer;

    Shown(const std::string& id, int index, int size)
        : scene(loadScene(id, SceneLibrary::standard())),
          frame(scene->frame(index)),
          tracer(frame.geometry, scene->materials, scene->images),
          gbuffer(renderGBuffer(tracer, frame, *scene, size, size)) {}

    glm::dvec3 world(std::size_t pixel) const {
        return glm::dvec3(gbuffer.position[pixel]) + scene->origin;
    }
    /// The exact reference of the scan's pixels; of all others, that they are background.
    std::vector<float> exact(const EdgeScan& scan) const {
        GBuffer asked = gbuffer;
        asked.mask.assign(asked.size(), PixelClass::background);
        for (const auto& bin : scan.pixels)
            for (const std::uint32_t pixel : bin) asked.mask[pixel] = gbuffer.mask[pixel];
        return exactReference(tracer, scene->materials, asked, frame.light, {}).visibility;
    }
    /// An image of `visibility(world position)`.
    template <class Visibility>
    std::vector<float> image(const Visibility& visibility) const {
        std::vector<float> out;
        for (std::size_t i = 0; i < gbuffer.size(); ++i)
            out.push_back(static_cast<float>(visibility(world(i))));
        return out;
    }
};

/// What measureEdge finds along the edge's segment, 2000 points of `visibility(world position)`.
template <class Visibility>
EdgeProfile along(const ShadowEdge& edge, const glm::dvec3& origin, const Visibility& visibility) {
    constexpr int kPoints = 2000;
    std::vector<double> positions, values;
    for (int i = 0; i < kPoints; ++i) {
        const double t = static_cast<double>(i) / (kPoints - 1);
        positions.push_back(t * glm::distance(edge.from, edge.to));
        values.push_back(visibility(glm::mix(edge.from, edge.to, t) + origin));
    }
    return measureEdge(positions, values).value();
}

/// Expects the scan of frame `index` to find what `visibility` says of `edge`, with errors of width
/// and centre in metres at most these.
template <class Visibility>
void expectClosedForm(const std::string& id, int index, std::size_t edge, double widthTolerance,
                      double centreTolerance, const Visibility& visibility) {
    const Shown shown(id, index, 256);
    const ShadowEdge& declared = shown.scene->edges.at(edge);
    const EdgeScan scan = scanEdge(declared, shown.gbuffer);
    const auto measured = scan.measured(shown.exact(scan));
    ASSERT_TRUE(measured) << id << " " << index;
    const EdgeProfile truth = along(declared, shown.scene->origin, visibility);
    EXPECT_LT(visibility(declared.from + shown.scene->origin), 0.1) << "the segment's sense";
    EXPECT_NEAR(measured->widthM, truth.widthM, widthTolerance) << id << " " << index;
    EXPECT_NEAR(measured->centreM, truth.centreM, centreTolerance) << id << " " << index;
}

// ---- the scenes' edges on exact references ----------------------------------------------------

// A crossing is found between two bins' means. Where the profile is straight over both, binning
// changes nothing: the nearest kink, at the penumbra's end, is then more than 1.5 bins off. What
// stays are positions and visibilities rounded to float and that rays start at
// Tracer::shadowOrigin, some 1e-5 m above the receiver.
constexpr double kExactM = 2e-5;

TEST(EdgeScan, HalfPlane) {
    // Bins of 0.012 m; a tenth of the penumbra is 0.096 m.
    const auto visibility = [](const glm::dvec3& p) {
        return closed_form::halfPlane(p.x, 0.0, 1.5, 1.6, 4.0);
    };
    expectClosedForm("half_plane", 0, 0, kExactM, kExactM, visibility);
    const Shown shown("half_plane", 0, 256);
    const EdgeProfile truth = along(shown.scene->edges.at(0), shown.scene->origin, visibility);
    EXPECT_NEAR(truth.widthM, kWidthM, 1e-9);
    EXPECT_NEAR(truth.centreM, 0.7, 1e-9) << "x0 = 0";
}

TEST(EdgeScan, ParallelRectangle) {
    // Bins of 0.016 m; the crossing at 0.1 is 0.027 m from where V has its least value, 1/16.
    expectClosedForm("parallel_rectangle", 0, 0, kExactM, kExactM, [](const glm::dvec3& p) {
        return closed_form::rectangle({p.x, p.z}, {{-0.4, -0.2}, {0.35, 0.6}}, 2.0,
                                      {{-1.0, -0.5}, {1.0, 0.5}}, 5.0);
    });
}

TEST(EdgeScan, TwoLayers) {
    // Nested: the light is hidden from one side, as far as the larger of the two reaches.
    expectClosedForm("two_layers", 0, 0, kExactM, kExactM, [](const glm::dvec3& p) {
        return std::min(closed_form::halfPlane(-p.x, 0.0, 1.5, 1.2, 4.0),
                        closed_form::halfPlane(-p.x, 0.0, 2.0, 1.2, 4.0));
    });
    for (const int frame : {1, 2})
        expectClosedForm("two_layers", frame, 1, kExactM, kExactM, [](const glm::dvec3& p) {
            return closed_form::halfPlane(p.x, -1.2, 1.5, 1.2, 4.0);
        });
}

TEST(EdgeScan, RecedingReceiver) {
    // Penumbrae of five to ten bins. A kink inside a bin moves its mean by at most an eighth of a
    // bin times the slope, and the chord to the next bin's mean as much again: a crossing shifts by
    // at most a quarter of a bin, the width by two of these over 0.8.
    constexpr double kBinM = 0.0162;
    for (const int frame : {0, 1, 2}) {
        const Shown shown("receding_receiver", frame, 1);
        AreaLight light = shown.frame.light;
        light.centre += shown.scene->origin;
        expectClosedForm("receding_receiver", frame, static_cast<std::size_t>(frame), 0.625 * kBinM,
                         0.25 * kBinM, [&](const glm::dvec3& p) {
                             return closed_form::straightEdge(
                                 p, {-5.0, 0.36, 1.08}, {5.0, 0.36, 1.08}, {0, 0.36, 9}, light);
                         });
    }
}

TEST(EdgeScan, FramesThatDoNotShowAnEdgeHaveNoPixelOfIt) {
    for (const int frame : {0, 1, 2}) {
        const Shown shown("receding_receiver", frame, 64);
        for (std::size_t edge = 0; edge < shown.scene->edges.size(); ++edge)
            EXPECT_EQ(scanEdge(shown.scene->edges[edge], shown.gbuffer).pixels.empty(),
                      edge != static_cast<std::size_t>(frame))
                << frame << " " << edge;
    }
}

// ---- scores ----------------------------------------------------------------------------------

/// The half plane's frame, its reference from R2.2.
class EdgeScores : public ::testing::Test {
  protected:
    /// A penumbra `width` as wide, its centre moved towards the light (-x) by `shift` widths.
    std::vector<float> drawn(double width, double shift) const {
        return shown.image([&](const glm::dvec3& p) {
            return std::clamp(0.5 - (p.x / kWidthM + shift) / width, 0.0, 1.0);
        });
    }
    Metrics score(const std::vector<float>& image) const {
        Reference reference = unshadowedReference(shown.gbuffer);
        reference.visibility = drawn(1.0, 0.0);
        return Scorer(reference, shown.gbuffer, shown.scene->edges).score(image);
    }
    const Shown shown{"half_plane", 0, 256};
};

// Widths within what float positions allow, see kExactM; a bin is 0.013 of the penumbra.
constexpr double kRounding = 2e-5;

TEST_F(EdgeScores, TheReferenceItselfHasNoError) {
    const Metrics m = score(drawn(1.0, 0.0));
    EXPECT_EQ(m.penumbraWidthError, 0.0);
    EXPECT_EQ(m.penumbraShift, 0.0);
}

TEST_F(EdgeScores, AWiderAndShiftedPenumbraReadsAsDrawn) {
    const Metrics wide = score(drawn(1.2, 0.0));
    EXPECT_NEAR(wide.penumbraWidthError.value(), 0.2, kRounding);
    EXPECT_NEAR(wide.penumbraShift.value(), 0.0, kRounding);
    const Metrics shifted = score(drawn(1.0, 0.1));
    EXPECT_NEAR(shifted.penumbraWidthError.value(), 0.0, kRounding);
    EXPECT_NEAR(shifted.penumbraShift.value(), 0.1, kRounding) << "the shadow is too large";
    const Metrics both = score(drawn(0.8, -0.1));
    EXPECT_NEAR(both.penumbraWidthError.value(), -0.2, kRounding);
    EXPECT_NEAR(both.penumbraShift.value(), -0.1, kRounding);
}

TEST_F(EdgeScores, AHardShadowHasNoWidthButAPixel) {
    const Metrics m = score(shown.image([](const glm::dvec3& p) { return p.x < 0.0 ? 1.0 : 0.0; }));
    // From one bin to the next or the one after, less a tenth of each.
    EXPECT_GT(m.penumbraWidthError.value(), -1.0);
    EXPECT_LT(m.penumbraWidthError.value(), -1.0 + 2 * 0.013);
    EXPECT_NEAR(m.penumbraShift.value(), 0.0, 0.013);
}

TEST_F(EdgeScores, UndefinedWhereTheImageHasNoSuchEdge) {
    const auto expectNone = [&](const std::vector<float>& image) {
        const Metrics m = score(image);
        EXPECT_FALSE(m.penumbraWidthError);
        EXPECT_FALSE(m.penumbraShift);
    };
    expectNone(std::vector<float>(shown.gbuffer.size(), 1.0f));
    expectNone(drawn(2.0, 0.0));
    std::vector<float> image = drawn(1.0, 0.0);
    image[scanEdge(shown.scene->edges[0], shown.gbuffer).pixels[3][0]] =
        std::numeric_limits<float>::quiet_NaN();
    expectNone(image);
}

/// Points on z = 0 under a light at z = 4, one centimetre apart, x and y from 0 to 2.
GBuffer table() {
    return test::planeGBuffer(200, 200, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, test::lightAbove(4, 1, 1));
}

TEST(EdgeScorer, MeansAreOverAllEdgesTheReferenceShows) {
    const GBuffer gbuffer = table();
    // Two edges across x at different y, one where the light's reach is not left.
    const std::vector<ShadowEdge> edges = {{{0.2, 0.5, 0}, {1.8, 0.5, 0}, 0.2},
                                           {{0.2, 1.5, 0}, {1.8, 1.5, 0}, 0.2},
                                           {{1.6, 0.5, 0}, {1.8, 0.5, 0}, 0.2}};
    const auto image = [&](double widthM, double upperWidthM) {
        std::vector<float> v;
        for (const glm::vec3& p : gbuffer.position)
            v.push_back(static_cast<float>(
                std::clamp(0.5 + (p.x - 1.0) / (p.y < 1.0f ? widthM : upperWidthM), 0.0, 1.0)));
        return v;
    };
    Reference reference = unshadowedReference(gbuffer);
    reference.visibility = image(0.5, 1.0);
    const Scorer scorer(reference, gbuffer, edges);
    const Metrics m = scorer.score(image(0.6, 1.0));
    EXPECT_NEAR(m.penumbraWidthError.value(), 0.1, 1e-5) << "of 0.2 and 0";
    EXPECT_FALSE(scorer.score(image(0.5, 4.0)).penumbraWidthError) << "an edge is missing";
    EXPECT_FALSE(Scorer(reference, gbuffer).score(image(0.6, 1.0)).penumbraWidthError)
        << "no edge is declared";
}

TEST(ScanEdge, TakesTheScoredPixelsOfTheBandOnTheSegmentsPlane) {
    GBuffer gbuffer = table();
    // Another layer half a metre above, as of a table over a floor.
    for (std::size_t i = 0; i < gbuffer.size(); ++i)
        if ((i + i / 200) % 2 == 0) gbuffer.position[i].z = 0.5f;
    gbuffer.mask[200 * 100 + 101] = PixelClass::horizon;
    const EdgeScan scan = scanEdge({{0.5, 1.0, 0}, {1.5, 1.0, 0}, 0.05}, gbuffer);
    std::size_t count = 0;
    for (std::size_t bin = 0; bin < scan.pixels.size(); ++bin) {
        ASSERT_FALSE(scan.pixels[bin].empty());
        double sum = 0.0;
        for (const std::uint32_t pixel : scan.pixels[bin]) {
            const glm::vec3& p = gbuffer.position[pixel];
            EXPECT_EQ(p.z, 0.0f);
            EXPECT_LE(std::abs(p.y - 1.0f), 0.05f);
            EXPECT_NE(pixel, 200u * 100u + 101u) << "no scored pixel";
            sum += p.x - 0.5;
            ++count;
        }
        EXPECT_NEAR(scan.positionsM[bin], sum / static_cast<double>(scan.pixels[bin].size()), 1e-9);
    }
    EXPECT_EQ(count, 10u * 50u - 1u) << "of ten rows of a hundred every other pixel";
    // A pixel in two square centimetres: bins of 1.4 cm over the 99 cm between the outer points.
    EXPECT_NEAR(static_cast<double>(scan.pixels.size()), 99 / std::sqrt(2.0), 2.0);
}

}  // namespace
}  // namespace penumbra
