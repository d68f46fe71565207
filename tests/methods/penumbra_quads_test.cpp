#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

class PenumbraQuads : public GlTest {};

constexpr double kLightM = 2.0, kHeightM = 0.5, kShadowM = 0.1;

/// What the paper's text describes.
Assignments paper(const Assignments& more = {}) {
    Assignments all = {
        {"stretch", "far_plane"}, {"corners", "averaged"}, {"profile", "linear"}, {"inner", "all"}};
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

/// HalfPlane of test_worlds.hpp as a closed slab a millimetre thick, of boxes side by side so that
/// its edge has vertices all along, over a floor which is a box raised to `raisedM` beyond y = 0.
struct Slab {
    double raisedM = 0.0;

    static double edgeM() { return kShadowM * (kLightM - kHeightM) / kLightM; }
    Shape shape() const {
        Shape shape;
        for (int i = -16; i < 16; ++i)
            shape.box({edgeM(), 0.1 * i, kHeightM}, {5.0, 0.1 * (i + 1), kHeightM + 0.001});
        shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
        if (raisedM > 0.0) shape.box({-2.0, 0.0, 0.0}, {2.0, 2.0, raisedM});
        return shape;
    }
    TestFrame frame(double widthM, double turnedDeg = 0.0, int size = 96) const {
        AreaLight light = lightAbove(kLightM, widthM, widthM);
        const double turn = glm::radians(turnedDeg);
        light.axisU = {std::cos(turn), std::sin(turn), 0.0};
        light.axisV = {std::sin(turn), -std::cos(turn), 0.0};
        const auto floor = [&](double y0, double z) {
            return planeGBuffer(size, size / 2, {-0.8, y0, z}, {1.6, 0, 0}, {0, 0.8, 0}, light);
        };
        return {{shape().geometry(), light}, stacked({floor(-0.8, 0.0), floor(0.0, raisedM)})};
    }
};

/// Width of the penumbra across x on the receiver z = `receiverM` at y of 0.2 to 0.6 metres: of the
/// line fitted to visibilities from 0.2 to 0.8.
double widthM(const TestFrame& frame, const Visibility& image) {
    double n = 0, sumX = 0, sumV = 0, sumXV = 0, sumVV = 0;
    for (const std::size_t i : frame.asked()) {
        const glm::dvec3 p(frame->gbuffer.position[i]);
        const double v = image[i];
        if (p.y < 0.2 || p.y > 0.6 || v < 0.2 || v > 0.8) continue;
        n += 1, sumX += p.x, sumV += v, sumXV += p.x * v, sumVV += v * v;
    }
    EXPECT_GT(n, 50);
    return -(n * sumXV - sumX * sumV) / (n * sumVV - sumV * sumV);
}

double rmse(const TestFrame& frame, const Visibility& image, const auto& truth) {
    double sum = 0.0;
    const std::vector<std::size_t> pixels = frame.asked();
    for (const std::size_t i : pixels) sum += std::pow(image[i] - truth(i), 2.0);
    return std::sqrt(sum / static_cast<double>(pixels.size()));
}

double greatestDifference(const TestFrame& frame, const Visibility& a, const Visibility& b) {
    double most = 0.0;
    for (const std::size_t i : frame.asked())
        most = std::max(most, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    return most;
}

TEST_F(PenumbraQuads, HalfPlaneIsALinearRampWhereTheFarPlaneIsTheReceiver) {
    const double width = 0.4;
    const TestFrame frame = Slab{}.frame(width);
    const auto truth = [&](std::size_t i) {
        return closed_form::halfPlane(static_cast<double>(frame->gbuffer.position[i].x),
                                      Slab::edgeM(), kHeightM, width, kLightM);
    };
    // Half a texel of a map of some 4 metres over 1024, 2 mm, in a penumbra of 133 mm.
    EXPECT_LT(rmse(frame, render(frame, "penumbra_quads", paper()), truth), 0.01);
    EXPECT_LT(rmse(frame, render(frame, "penumbra_quads"), truth), 0.01);
    EXPECT_LT(rmse(frame, render(frame, "penumbra_quads", {{"stretch", "vertex"}}), truth), 0.01);
    EXPECT_GT(rmse(frame, render(frame, "hard"), truth), 0.05) << "the test can fail";
}

TEST_F(PenumbraQuads, NearerReceiversAreWiderByThePredictedRatio) {
    const double width = 0.4, raised = 0.25;
    const TestFrame frame = Slab{raised}.frame(width, 0.0, 192);
    const double zA = kLightM - kHeightM, zr = kLightM - raised, zf = kLightM;
    const double trueM = width * (zr - zA) / zA;
    const double ratio = (1 / zA - 1 / zf) / (1 / zA - 1 / zr);
    const auto of = [&](const char* stretch) {
        return widthM(frame, render(frame, "penumbra_quads",
                                    {{"stretch", stretch}, {"map_size", "2048"}})) /
               trueM;
    };
    EXPECT_NEAR(of("far_plane") / ratio, 1.0, 0.03);  // the bound
    EXPECT_NEAR(of("vertex"), 1.0, 0.03);
    EXPECT_NEAR(of("texel"), 1.0, 0.03);
}

TEST_F(PenumbraQuads, HalfAtTheHardEdgeFromBothSides) {
    const double width = 0.4;
    const TestFrame frame = Slab{}.frame(width, 0.0, 192);
    const double penumbraM = width * kHeightM / (kLightM - kHeightM);
    // The value belongs to a texel's centre, up to half a texel off; a whole one for the filter.
    const double texel = texelM(frame, 0.0, 1024, kLightM);
    const Visibility image = render(frame, "penumbra_quads");
    int before = 0, behind = 0;
    for (const std::size_t i : frame.asked()) {
        const double x = static_cast<double>(frame->gbuffer.position[i].x) - kShadowM;
        if (std::abs(x) > 0.01) continue;
        (x < 0.0 ? before : behind)++;
        EXPECT_NEAR(image[i], 0.5 - x / penumbraM, texel / penumbraM) << x;
    }
    EXPECT_GT(before, 50);
    EXPECT_GT(behind, 50);
}

TEST_F(PenumbraQuads, NoLightSizeIsTheHardMap) {
    const TestFrame point = Slab{0.25}.frame(0.0);
    const Visibility hard = render(point, "hard");
    EXPECT_EQ(render(point, "penumbra_quads"), hard);
    const TestFrame wide = Slab{0.25}.frame(0.4);
    EXPECT_EQ(render(wide, "penumbra_quads", {}, EffectChoice::parse("none")), hard);
    // A micrometre: pixels nearer to an edge than its penumbra are none but by chance.
    const TestFrame tiny = Slab{0.25}.frame(1e-6);
    EXPECT_LE(violations(tiny, render(tiny, "penumbra_quads"),
                         [&](float v, std::size_t i) { return v == hard[i]; }),
              5);
}

TEST_F(PenumbraQuads, ProfileIsThatOfATurnedRectangle) {
    for (const double turned : {15.0, 30.0, 45.0}) {
        const TestFrame frame = Slab{}.frame(0.4, turned, 192);
        const auto truth = [&](std::size_t i) {
            return closed_form::straightEdge(
                glm::dvec3(frame->gbuffer.position[i]), {Slab::edgeM(), -1.0, kHeightM},
                {Slab::edgeM(), 1.0, kHeightM}, {-1.0, 0.0, kHeightM}, frame->light);
        };
        const double exact = rmse(frame, render(frame, "penumbra_quads"), truth);
        EXPECT_LT(exact, 0.01) << turned;  // texels, as above
        // A ramp over the light's whole width instead of a curve that is steeper in its middle.
        EXPECT_GT(rmse(frame, render(frame, "penumbra_quads", {{"profile", "linear"}}), truth),
                  1.5 * exact)
            << turned;
    }
}

TEST_F(PenumbraQuads, EdgesTiltedInDepthAreExactToo) {
    // One edge without vertices between, from 0.2 to 0.8 metres over the floor: its penumbra is
    // five times as wide at one end as at the other.
    const glm::dvec3 a(0.1, -2.0, 0.2), b(0.1, 2.0, 0.8), across(3.0, 0.0, 0.0);
    Shape shape;
    shape.quad(a, a + across, b + across, b);
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    const AreaLight light = lightAbove(kLightM, 0.4, 0.4);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(192, 192, {-0.6, -0.8, 0}, {1.4, 0, 0}, {0, 1.6, 0}, light));
    const auto truth = [&](std::size_t i) {
        return closed_form::straightEdge(glm::dvec3(frame->gbuffer.position[i]), a, b, a - across,
                                         light);
    };
    // Texels, as above; with the share of the quad interpolated, not what it moved by, it is 0.027.
    EXPECT_LT(rmse(frame, render(frame, "penumbra_quads"), truth), 0.003);
}

TEST_F(PenumbraQuads, ThirdSurfaceStaysDark) {
    // Two plates over the floor; the upper one's edge runs above the lower one's middle.
    const AreaLight light = lightAbove(2.0, 0.4, 0.4);
    Shape shape;
    shape.box({0.0, -2.0, 1.0}, {2.0, 2.0, 1.01});
    shape.box({-0.3, -2.0, 0.5}, {0.3, 2.0, 0.51});
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    const auto plane = [&](double z) {
        return planeGBuffer(64, 16, {0.02, -0.3, z}, {0.25, 0, 0}, {0, 0.6, 0}, light);
    };
    const TestFrame frame({shape.geometry(), light}, stacked({plane(0.51), plane(0.0)}));
    const Visibility image = render(frame, "penumbra_quads");
    int second = 0;
    for (std::size_t i = 0; i < 64 * 16; ++i) second += image[i] > 0.05f && image[i] < 0.5f;
    EXPECT_GT(second, 200) << "the second surface has the upper plate's inner penumbra";
    for (std::size_t i = 64 * 16; i < image.size(); ++i) EXPECT_EQ(image[i], 0.0f);
}

/// Two plates that overlap as the light sees them.
Shape overlappingPlates() {
    Shape shape;
    shape.box({-0.5, -0.4, 0.8}, {0.1, 0.2, 0.82});
    shape.box({-0.1, -0.1, 0.4}, {0.5, 0.5, 0.42});
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    return shape;
}

World overFloor(std::shared_ptr<const Geometry> geometry) {
    return {std::move(geometry), lightAbove(2.0, 0.4, 0.3)};
}

TestFrame seenOnFloor(const World& world) {
    return {world, planeGBuffer(128, 128, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, world.light)};
}

TEST_F(PenumbraQuads, OrderOfDrawingDoesNotMatter) {
    const auto geometry = overlappingPlates().geometry();
    // The last vertex and triangle first.
    auto reversed = std::make_shared<Geometry>(*geometry);
    std::ranges::reverse(reversed->positions);
    std::ranges::reverse(reversed->normals);
    const std::size_t triangles = geometry->triangleCount();
    for (std::size_t t = 0; t < triangles; ++t)
        for (std::size_t k = 0; k < 3; ++k)
            reversed->indices[3 * t + k] =
                static_cast<std::uint32_t>(geometry->positions.size() - 1) -
                geometry->indices[3 * (triangles - 1 - t) + k];
    const TestFrame frame = seenOnFloor(overFloor(geometry)),
                    other = seenOnFloor(overFloor(reversed));
    // Edges run the other way and round otherwise, no more ...
    const Assignments all = {{"inner", "all"}};
    EXPECT_LT(greatestDifference(frame, render(frame, "penumbra_quads", all),
                                 render(other, "penumbra_quads", all)),
              1e-4);
    // ... which may take the place asked beside an edge from a texel to the next: of 16384 pixels,
    // the few whose place lies on a texel's border at another plate's rim.
    const Visibility image = render(other, "penumbra_quads");
    EXPECT_LE(violations(frame, render(frame, "penumbra_quads"),
                         [&](float v, std::size_t i) { return std::abs(v - image[i]) < 1e-4; }),
              8);
    const Assignments inOrder = {{"overlap", "draw_order"}, {"inner", "all"}};
    EXPECT_GT(greatestDifference(frame, render(frame, "penumbra_quads", inOrder),
                                 render(other, "penumbra_quads", inOrder)),
              0.1)
        << "what the paper's hardware did";
}

/// Shapes side by side, each with one vertex at each of its corners.
std::shared_ptr<const Geometry> sharingCorners(const std::vector<Shape>& shapes) {
    std::vector<std::pair<Shape, int>> parts;
    for (const Shape& shape : shapes) parts.emplace_back(shape, 0);
    auto whole = std::make_shared<Geometry>(*joined(parts));
    for (const Part& part : whole->parts) {
        const auto first = whole->positions.begin() + part.firstVertex;
        for (std::uint32_t i = part.firstIndex; i < part.firstIndex + part.indexCount; ++i) {
            std::uint32_t& index = whole->indices[i];
            const auto same = std::find(first, whole->positions.end(), whole->positions[index]);
            index = static_cast<std::uint32_t>(same - whole->positions.begin());
        }
    }
    return whole;
}

TEST_F(PenumbraQuads, SeamsCastFalsePenumbraeUnlessWelded) {
    // The paper's wing and fuselage: two boxes with a side in common, which lies above the middle
    // of their shadow.
    Shape wing, fuselage, floor;
    wing.box({-0.8, -0.8, 0.5}, {0.05, 0.8, 0.6});
    fuselage.box({0.05, -0.8, 0.5}, {0.8, 0.8, 0.6});
    floor.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    const World world = overFloor(sharingCorners({wing, fuselage, floor}));
    const TestFrame frame(
        world, planeGBuffer(64, 64, {-0.4, -0.4, 0}, {0.8, 0, 0}, {0, 0.8, 0}, world.light));
    EXPECT_EQ(unequal(frame, render(frame, "penumbra_quads", paper()), 0.0f), 0);
    const Visibility loose = render(frame, "penumbra_quads", paper({{"weld", "false"}}));
    // Half visibility along the seam, where there is none, less what 6 mm between pixels and the
    // seam are of its 67 mm.
    EXPECT_GT(*std::ranges::max_element(loose), 0.35f);
}

TEST_F(PenumbraQuads, AveragedNormalsAreNarrowAtRightAngles) {
    // A square plate turned by 45 degrees under a square light: the vertices' normals point along
    // the light's axes, where it reaches R; across the sides that is R cos 45, while the light's
    // corner reaches R / cos 45: half as wide.
    const double R = 0.2;
    Shape shape;
    const double a = 0.3;
    for (const double z : {0.5, 0.501}) {
        const glm::dvec3 c[4] = {{a, 0, z}, {0, a, z}, {-a, 0, z}, {0, -a, z}};
        if (z > 0.5)
            shape.quad(c[0], c[1], c[2], c[3]);
        else
            shape.quad(c[0], c[3], c[2], c[1]);
    }
    const auto rim = [&](double x, double y, double z) { return glm::dvec3(x, y, z); };
    const glm::dvec2 corner[5] = {{a, 0}, {0, a}, {-a, 0}, {0, -a}, {a, 0}};
    for (int i = 0; i < 4; ++i)
        shape.quad(rim(corner[i].x, corner[i].y, 0.5), rim(corner[i + 1].x, corner[i + 1].y, 0.5),
                   rim(corner[i + 1].x, corner[i + 1].y, 0.501),
                   rim(corner[i].x, corner[i].y, 0.501));
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    const AreaLight light = lightAbove(kLightM, 2 * R, 2 * R);
    // Outward across the middle of one side, from its shadow's edge on.
    const double edge = a / std::sqrt(2.0) * kLightM / (kLightM - 0.5);
    const double along = 1.0 / std::sqrt(2.0), outM = 0.15;
    const TestFrame frame(
        {shape.geometry(), light},
        planeGBuffer(128, 8, {(edge + 0.01) * along, (edge - 0.01) * along, 0},
                     {outM * along, outM * along, 0}, {-0.02 * along, 0.02 * along, 0}, light));
    const auto reach = [&](const char* corners) {
        const Visibility image =
            render(frame, "penumbra_quads", {{"corners", corners}, {"profile", "linear"}});
        double lit = 0.0;
        for (const float v : image) lit += 2.0 * (1.0 - v) / static_cast<double>(image.size());
        return 2.0 * lit * outM;  // the ramp's triangle
    };
    const double half = R * 0.5 / (kLightM - 0.5);  // on the floor
    // Two texels of 2 mm in 47 and 94 mm.
    EXPECT_NEAR(reach("averaged"), half / std::sqrt(2.0), 0.004);
    EXPECT_NEAR(reach("filled"), half * std::sqrt(2.0), 0.004);
}

TEST_F(PenumbraQuads, EdgeOnFacesHaveOneQuad) {
    // The light's centre in the plane of a side, of two sides, and a hair beside them.
    Shape shape;
    shape.box({0.1, 0.2, 0.4}, {0.5, 0.6, 0.6});
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    const auto at = [&](const glm::dvec2& place) {
        World world{shape.geometry(), lightAbove(2.0, 0.3, 0.3)};
        world.light.centre = {place, 2.0};
        const TestFrame frame = seenOnFloor(world);
        return render(frame, "penumbra_quads");
    };
    for (const glm::dvec2& place :
         {glm::dvec2(0.1, 0.0), glm::dvec2(0.1, 0.2), glm::dvec2(0.5, 0.6)}) {
        // As float rounds the box, so that the centre is in its planes indeed.
        const Visibility exactly = at(glm::dvec2(glm::vec2(place)));
        double least = 1.0;
        for (const double beside : {-1e-4, 1e-4}) {
            const Visibility other = at(glm::dvec2(glm::vec2(place)) + beside);
            double sum = 0.0;
            for (std::size_t i = 0; i < other.size(); ++i)
                sum += std::pow(other[i] - exactly[i], 2.0);
            least = std::min(least, std::sqrt(sum / static_cast<double>(other.size())));
        }
        // As on one side of the plane: on the other, the side's other edge is the silhouette. A
        // quad missing or doubled would be 0.4 m of a 2 m floor, off by up to a half: 0.03.
        EXPECT_LT(least, 0.003) << place.x << ", " << place.y;
    }
}

TEST_F(PenumbraQuads, OpenSheetsCastLikeThinPlates) {
    Shape floor, sheet, plate;
    floor.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    sheet = plate = floor;
    sheet.rectangle({-0.4, -0.3}, {0.3, 0.4}, 0.5);
    plate.box({-0.4, -0.3, 0.5}, {0.3, 0.4, 0.5001});
    const TestFrame frame = seenOnFloor(overFloor(sheet.geometry())),
                    closed = seenOnFloor(overFloor(plate.geometry()));
    // A tenth of a millimetre shifts edges by less than a texel.
    EXPECT_LT(greatestDifference(frame, render(frame, "penumbra_quads"),
                                 render(closed, "penumbra_quads")),
              0.05);
}

std::string messageFor(const TestFrame& frame) {
    const auto method = findMethod("penumbra_quads").make();
    const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
    method->prepare(frame->scene, plan);
    method->build(*frame, plan);
    return method->counters().message;
}

TEST_F(PenumbraQuads, MessageCountsBadEdges) {
    EXPECT_EQ(messageFor(seenOnFloor(overFloor(overlappingPlates().geometry()))), "");
    Shape open = overlappingPlates();
    open.rectangle({-0.2, -0.2}, {0.2, 0.2}, 0.3);
    EXPECT_EQ(messageFor(seenOnFloor(overFloor(open.geometry()))), "59 edges: 4 open edges");
}

TEST_F(PenumbraQuads, BadMeshesAreCountedAndDrawnLikeTheirCleanSelves) {
    const Shape floor = [] {
        Shape shape;
        shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
        return shape;
    }();
    Shape clean = floor;
    clean.box({-0.4, -0.3, 0.5}, {0.3, 0.4, 0.6});
    const TestFrame frame = seenOnFloor(overFloor(clean.geometry()));
    const Visibility truth = render(frame, "penumbra_quads");
    const auto differs = [&](const Shape& shape, const char* message) {
        const TestFrame other = seenOnFloor(overFloor(shape.geometry()));
        EXPECT_EQ(messageFor(other), message);
        return greatestDifference(frame, render(other, "penumbra_quads"), truth);
    };
    // The same silhouettes, cut elsewhere: rounding, and quads' overlap of 1/128 of a texel.
    const double same = 1e-3;

    Shape twice = clean;  // every face again
    twice.box({-0.4, -0.3, 0.5}, {0.3, 0.4, 0.6});
    EXPECT_LT(differs(twice, "36 edges: 12 back-to-back triangles dropped"), same);

    Shape slivers = clean;
    slivers.quad({-0.4, -0.3, 0.6}, {-0.4, -0.3, 0.6}, {0.3, 0.4, 0.6}, {0.3, 0.4, 0.6});
    EXPECT_LT(differs(slivers, "36 edges: 2 degenerate triangles dropped"), same);

    Shape walled = floor;  // two boxes that share a wall
    walled.box({-0.4, -0.3, 0.5}, {0.0, 0.4, 0.6});
    walled.box({0.0, -0.3, 0.5}, {0.3, 0.4, 0.6});
    EXPECT_LT(differs(walled, "48 edges: 4 back-to-back triangles dropped"), same);

    Shape junctions = floor;  // the roof's front half is cut in two, the walls are not
    const glm::dvec3 lo(-0.4, -0.3, 0.5), hi(0.3, 0.4, 0.6);
    const auto at = [&](double x, double y, double z) {
        return glm::mix(lo, hi, glm::dvec3(x, y, z));
    };
    junctions.quad(at(0, 0, 1), at(0.5, 0, 1), at(0.5, 1, 1), at(0, 1, 1));
    junctions.quad(at(0.5, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0.5, 1, 1));
    junctions.quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
    junctions.quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    junctions.quad(at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1));
    junctions.quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    junctions.quad(at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1));
    EXPECT_LT(differs(junctions, "40 edges: 2 T-junctions split"), same);

    Shape finned = clean;  // a fin on the roof, inside its outline: a fan of three faces
    finned.quad({-0.4, -0.3, 0.6}, {0.3, -0.3, 0.6}, {0.3, -0.3, 0.7}, {-0.4, -0.3, 0.7});
    const Visibility fin = render(seenOnFloor(overFloor(finned.geometry())), "penumbra_quads");
    EXPECT_EQ(messageFor(seenOnFloor(overFloor(finned.geometry()))),
              "40 edges: 3 open edges, 1 non-manifold edges");
    EXPECT_EQ(violations(frame, fin, [](float v, std::size_t) { return v >= 0.0f && v <= 1.0f; }),
              0);

    auto nowhere = std::make_shared<Geometry>(*clean.geometry());
    nowhere->positions[3].x = std::numeric_limits<float>::infinity();
    EXPECT_THROW(render(seenOnFloor(overFloor(nowhere)), "penumbra_quads"), Unsupported);
}

/// A strip from x = 0 to `widthM` over the floor, kHeightM high, under a light `lightM` wide.
World strip(double widthM, double lightM, const Shape& more = {}) {
    Shape shape = more;
    shape.box({0.0, -1.5, kHeightM}, {widthM, 1.5, kHeightM + 0.001});
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    return {shape.geometry(), lightAbove(kLightM, lightM, lightM)};
}

TEST_F(PenumbraQuads, WiresKeepADarkCoreOfAHalf) {
    // Each side of a wire is drawn as if the wire had no other: from 1/2 at its edges' shadows
    // outward, where in truth the light sees around it on both sides.
    const double wire = 0.01, width = 0.4;
    const World world = strip(wire, width);
    const TestFrame frame(
        world, planeGBuffer(256, 8, {-0.1, -0.05, 0}, {0.22, 0, 0}, {0, 0.1, 0}, world.light));
    const double penumbraM = width * kHeightM / (kLightM - kHeightM);
    const double shadowM = wire * kLightM / (kLightM - kHeightM);
    const double texel = texelM(frame, 0.0, 1024, kLightM);
    const Visibility image = render(frame, "penumbra_quads");
    double darkest = 1.0;
    for (const std::size_t i : frame.asked()) {
        const double x = static_cast<double>(frame->gbuffer.position[i].x);
        const double outside = std::max(-x, x - shadowM);  // negative: within the hard shadow
        const double predicted = std::clamp(0.5 + outside / penumbraM, 0.0, 1.0);
        EXPECT_NEAR(image[i], predicted, 1.5 * texel / penumbraM) << x;
        darkest = std::min(darkest, static_cast<double>(image[i]));
    }
    EXPECT_LT(darkest, 0.5);
    // The strip as the floor sees it on the light.
    EXPECT_GT(1.0 - wire * kLightM / kHeightM / width, 0.89) << "and the truth";
}

TEST_F(PenumbraQuads, InnerQuadsReachPastNarrowParts) {
    // Below the strip a wide plate goes on where, for the light's centre, the strip ends: the
    // strip's other edge lights what the plate shadows. The paper's identities see that.
    const double width = 0.8, strips = 0.02, plate = 0.25;
    Shape lower;
    lower.box({0.012, -1.5, plate}, {1.0, 1.5, plate + 0.001});
    const World world = strip(strips, width, lower);
    const double umbraM = 0.08, toM = 0.12;
    const TestFrame frame(world, planeGBuffer(64, 8, {umbraM, -0.05, 0}, {toM - umbraM, 0, 0},
                                              {0, 0.1, 0}, world.light));
    const double penumbraM = width * kHeightM / (kLightM - kHeightM);
    const Visibility image = render(frame, "penumbra_quads");
    const double texel = texelM(frame, 0.0, 1024, kLightM);
    for (const std::size_t i : frame.asked()) {
        const double x = static_cast<double>(frame->gbuffer.position[i].x);
        // The strip's side is edge-on: of its edges, a millimetre apart, either may count.
        EXPECT_NEAR(image[i], 0.5 - x / penumbraM, 1.5 * texel / penumbraM + 0.001) << x;
    }
    EXPECT_EQ(unequal(frame, render(frame, "penumbra_quads", {{"inner", "pieces"}}), 0.0f), 0);
    EXPECT_EQ(unequal(frame, render(frame, "ray_traced"), 0.0f), 0) << "it is umbra";
}

TEST_F(PenumbraQuads, QuadsBoundedByTheirReceiversAreTheSame) {
    // Many boxes below the floor make the mesh one whose quads are bounded; none is seen.
    Shape shape = overlappingPlates();
    const TestFrame frame = seenOnFloor(overFloor(shape.geometry()));
    for (int y = 0; y < 54; ++y)
        for (int x = 0; x < 54; ++x) {
            const glm::dvec3 at(-1.5 + 0.05 * x, -1.5 + 0.05 * y, -0.08);
            shape.box(at, at + 0.02);
        }
    const TestFrame many = seenOnFloor(overFloor(shape.geometry()));
    // Overlaps of 1/128 of a texel move samples by no more, in penumbrae of fifteen texels or so.
    EXPECT_LT(
        greatestDifference(frame, render(frame, "penumbra_quads"), render(many, "penumbra_quads")),
        1e-3);
}

TEST_F(PenumbraQuads, PreparingAgainChangesNothing) {
    const TestFrame frame = seenOnFloor(overFloor(overlappingPlates().geometry()));
    const auto method = findMethod("penumbra_quads").make();
    const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
    const TextureTarget target(frame->width(), frame->height());
    for (int i = 0; i < 2; ++i) {
        method->prepare(frame->scene, plan);
        method->build(*frame, plan);
        method->shade(*frame, plan, target);
        EXPECT_EQ(target.read(), render(frame, "penumbra_quads"));
    }
}

TEST_F(PenumbraQuads, RefusesWhatItCannotDraw) {
    World masked = overFloor(overlappingPlates().geometry());
    masked.materials[0].masked = true;
    EXPECT_NO_THROW(render(seenOnFloor(masked), "penumbra_quads")) << "nothing is cut out";
    masked.materials[0].baseColor.a = 0.25f;
    EXPECT_THROW(render(seenOnFloor(masked), "penumbra_quads"), Unsupported);

    // A wall beside the light, whose upper part lies 84 degrees off its normal.
    Shape room;
    room.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    room.box({2.0, -2.0, 0.0}, {2.1, 2.0, 2.0});
    const World walled = overFloor(room.geometry());
    const TestFrame wall(
        walled, planeGBuffer(32, 32, {2.0, 1.0, 0.1}, {0, -2, 0}, {0, 0, 1.7}, walled.light));
    EXPECT_THROW(render(wall, "penumbra_quads"), Unsupported);
    EXPECT_NO_THROW(render(wall, "penumbra_quads", {}, EffectChoice::parse("none")))
        << "without penumbrae it is the hard map";
}

TEST_F(PenumbraQuads, TallCastersAreClippedAtTheLightsPlane) {
    // A tower beside the light and above it: nothing of its penumbra on the light's other side.
    Shape shape;
    shape.box({-2.0, -2.0, -0.1}, {2.0, 2.0, 0.0});
    shape.box({0.5, -0.3, 0.0}, {0.6, 0.3, 4.0});
    const World world{shape.geometry(), lightAbove(2.0, 0.3, 0.3)};
    const TestFrame frame(
        world, planeGBuffer(64, 64, {-1.0, -1.0, 0}, {1.45, 0, 0}, {0, 2, 0}, world.light));
    for (const char* stretch : {"texel", "vertex", "far_plane"})
        EXPECT_EQ(unequal(frame, render(frame, "penumbra_quads", {{"stretch", stretch}}), 1.0f), 0)
            << stretch;
}

}  // namespace
}  // namespace penumbra
