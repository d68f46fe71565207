// exactReference where polygon clipping usually breaks (METHODS.md, hard cases 43, 51, 53).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "tests/analytic/exact_support.hpp"

namespace penumbra {
namespace {

using test::Corners;
using test::exactAt;
using test::exactOf;
using test::floorPoints;
using test::lightAbove;
using test::Shape;
using test::shapeOf;
using test::soup;

constexpr double kTolerance = 1e-5;  ///< as in exact_test.cpp

/// The greatest difference in visibility, and in irradiance as a share of the unshadowed.
double difference(const Reference& a, const Reference& b) {
    double worst = 0.0;
    for (std::size_t i = 0; i < a.visibility.size(); ++i) {
        EXPECT_TRUE(std::isfinite(a.visibility[i]) && std::isfinite(a.irradiance[i]));
        worst = std::max(worst, std::abs(double{a.visibility[i]} - b.visibility[i]));
        if (a.irradianceUnshadowed[i] > 0.0f)
            worst = std::max(worst, std::abs(double{a.irradiance[i]} - b.irradiance[i]) /
                                        a.irradianceUnshadowed[i]);
    }
    return worst;
}

TEST(ExactHardCases, WallThroughTheReceiverPlane) {
    // A wall at x = 0.5 from below the floor up to z = 1 hides the light beyond x = H 0.5 / 1.
    const AreaLight light = lightAbove(4.0, 6.0, 1.0);
    Shape wall;
    wall.quad({0.5, -20, -3}, {0.5, 20, -3}, {0.5, 20, 1}, {0.5, -20, 1});
    EXPECT_NEAR(exactAt(wall, {0, 0, 0}, light), 5.0 / 6.0, kTolerance);
    EXPECT_NEAR(exactAt(wall, {0.25, 0.1, 0}, light), (3.0 + 0.25 + 4 * 0.25) / 6.0, kTolerance);
    // All but touching the wall: its image is all that lies beyond.
    EXPECT_NEAR(exactAt(wall, {0.5 - 1e-4, 0, 0}, light), (3.0 + 0.5) / 6.0, 1e-4);
}

TEST(ExactHardCases, WallThroughTheLightPlane) {
    // At x = 1 from z = 2 up, across the light. Seen from the origin it hides x from 1 to H/2, less
    // the last 1e-4 of the way to the light that does not count.
    const AreaLight light = lightAbove(4.0, 6.0, 1.0);
    Shape wall;
    wall.quad({1, -20, 2}, {1, 20, 2}, {1, 20, 9}, {1, -20, 9});
    const double from = 1.0 / (1.0 - 1e-4);
    EXPECT_NEAR(exactAt(wall, {0, 0, 0}, light), 1.0 - (2.0 - from) / 6.0, kTolerance);
    // The same, through both planes at once.
    Shape tall;
    tall.quad({1, -20, -5}, {1, 20, -5}, {1, 20, 9}, {1, -20, 9});
    EXPECT_NEAR(exactAt(tall, {0, 0, 0}, light), 1.0 - (3.0 - from) / 6.0, kTolerance);
}

TEST(ExactHardCases, ObliqueTriangleThroughBothPlanesHidesOneSideOfItsPlane) {
    const AreaLight light = lightAbove(4.0, 2.0, 2.0);
    // In the plane x = 0.2 + 0.1 z, far larger than the scene: all light beyond it is hidden.
    Shape shape;
    const auto on = [](double y, double z) { return glm::dvec3(0.2 + 0.1 * z, y, z); };
    shape.triangle(on(-90, -30), on(90, -30), on(0, 90));
    const double from = (0.2 + 0.4 * (1.0 - 1e-4)) / (1.0 - 1e-4);
    EXPECT_NEAR(exactAt(shape, {0, 0, 0}, light), 0.5 * (1.0 + from), kTolerance);
}

TEST(ExactHardCases, NothingInAndBesideTheLightsPlaneOrBelowCounts) {
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape shape;
    shape.rectangle({-5, -5}, {5, 5}, 4.0);   // in the light's plane
    shape.rectangle({-5, -5}, {5, 5}, 4.5);   // behind the light
    shape.rectangle({-5, -5}, {5, 5}, -0.5);  // below the point
    shape.rectangle({-5, -5}, {5, 5}, 0.0);   // the point's own surface
    shape.rectangle({0.2, -1}, {1, 1}, 2.0);  // beside the shaft
    EXPECT_EQ(exactAt(shape, {-0.3, 0, 0}, light), 1.0);
}

TEST(ExactHardCases, EdgeOnTrianglesHideNothing) {
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape shape;  // in a plane that holds the point
    shape.quad({0.0, -1, 0.5}, {0.0, 1, 0.5}, {0.0, 1, 3}, {0.0, -1, 3});
    EXPECT_NEAR(exactAt(shape, {0, 0, 0}, light), 1.0, 1e-9);
}

TEST(ExactHardCases, SliversHideTheirArea) {
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape shape;
    double image = 0.0;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-0.2, 0.2);
    for (int i = 0; i < 40; ++i) {  // 1e-6 by 1e-6, and 1 by 1e-12 where float can say it: z = 0
        const glm::dvec3 at(unit(random), unit(random), 2.0);
        shape.triangle(at, at + glm::dvec3(1e-6, 0, 0), at + glm::dvec3(0, 1e-6, 0));
        image += 4 * 0.5e-12;
        shape.triangle({0.0, 1e-12 * i, 2.0}, {0.4, 0.0, 2.0}, {-0.4, 0.0, 2.0});
        image += 4 * 0.4e-12 * i;
    }
    const double v = exactAt(shape, {0, 0, 0}, light);
    EXPECT_TRUE(std::isfinite(v));
    EXPECT_NEAR(v, 1.0, image + 1e-12);
}

TEST(ExactHardCases, OrderAndWindingAndCopiesOfTrianglesDoNotMatter) {
    const AreaLight light = lightAbove(4.0, 1.6, 1.2);
    const GBuffer points = floorPoints(40, light);
    std::vector<Corners> triangles = soup(80, 3);
    const Reference first = exactOf(shapeOf(triangles), points, light);
    std::vector<Corners> copies = triangles;
    copies.insert(copies.end(), triangles.begin(), triangles.end());
    for (std::size_t i = 0; i < copies.size(); i += 3) std::swap(copies[i].a, copies[i].b);
    std::shuffle(copies.begin(), copies.end(), std::mt19937(1));
    // One ulp of float.
    EXPECT_LE(difference(first, exactOf(shapeOf(copies), points, light)), 6e-8);
}

TEST(ExactHardCases, MeshingDoesNotMatter) {
    // A tilted plate as two triangles, as a grid, and as grids that overlap without sharing edges.
    const AreaLight light = lightAbove(4.0, 1.6, 1.2);
    const GBuffer points = floorPoints(40, light);
    const glm::dvec3 corner(-0.5, -0.5, 1.0), u(1.0, 0.125, 0.5), v(-0.25, 1.0, 0.75);
    Shape whole, fine, coarse;
    whole.grid(corner, u, v, 1);
    fine.grid(corner, u, v, 16);
    coarse.grid(corner, u, v, 5);
    coarse.grid(corner, u, v, 3);
    const Reference truth = exactOf(whole, points, light);
    EXPECT_LE(difference(truth, exactOf(fine, points, light)), kTolerance);
    EXPECT_LE(difference(truth, exactOf(coarse, points, light)), kTolerance);
}

TEST(ExactHardCases, GroupsOfPixelsDoNotMatter) {
    // Alone, each pixel has a shaft and outlines of its own. Points far apart in one tile share
    // none of theirs.
    const AreaLight light = test::turned(lightAbove(4.0, 1.6, 1.2), test::turn({1, 2, 0}, 0.3));
    const Shape shape = shapeOf(soup(400, 11));
    const GBuffer points = floorPoints(33, light);
    const Reference together = exactOf(shape, points, light);
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    int partial = 0;
    for (std::size_t i = 0; i < points.size(); i += 7) {
        const GBuffer one = test::pointGBuffer({glm::dvec3(points.position[i])}, {0, 0, 1}, light);
        const Reference alone = exactReference(tracer, test::kOpaque, one, light);
        ASSERT_NEAR(alone.visibility[0], together.visibility[i], 6e-8) << i;
        ASSERT_NEAR(alone.irradiance[0], together.irradiance[i], 6e-8) << i;
        partial += alone.visibility[0] > 0.0f && alone.visibility[0] < 1.0f;
    }
    EXPECT_GT(partial, 50);
}

TEST(ExactHardCases, SurfacesDoNotHideTheirOwnSky) {
    // A sphere, and a plane of many cells that leans: where the whole light is above the horizon
    // of a point on a convex surface, it sees all of it.
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape sphere, plane;
    sphere.sphere({0, 0, 0}, 1.0, 24);
    plane.grid({-1, -1, -0.3}, {2, 0.1, 0.6}, {-0.2, 2, 0.4}, 16);
    for (const Shape& shape : {sphere, plane}) {
        const auto geometry = shape.geometry();
        const Tracer tracer(geometry, test::kOpaque, test::kNoImages);
        std::size_t scored = 0;
        for (std::size_t t = 0; t < geometry->triangleCount(); t += 3) {
            const auto corner = [&](int k) {
                return glm::dvec3(geometry->positions[geometry->indices[3 * t + k]]);
            };
            const glm::dvec3 normal =
                glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
            const glm::dvec3 p = 0.2 * corner(0) + 0.7 * corner(1) + 0.1 * corner(2);
            const GBuffer point = test::pointGBuffer({p}, normal, light);
            if (point.mask[0] != PixelClass::scored) continue;
            ++scored;
            EXPECT_EQ(exactReference(tracer, test::kOpaque, point, light).visibility[0], 1.0f);
        }
        EXPECT_GT(scored, 20u);
    }
}

TEST(ExactHardCases, RigidMotionAndScaleDoNotMatter) {
    const AreaLight light = lightAbove(4.0, 1.6, 0.016);  // 100 : 1
    const std::vector<Corners> triangles = soup(60, 17);
    const GBuffer points = floorPoints(24, light);
    const Reference truth = exactOf(shapeOf(triangles), points, light);
    const glm::dmat3 rotation = test::turn({0.3, -1.0, 0.5}, 2.0);
    for (const double scale : {1e-3, 1.0, 1e3}) {
        AreaLight moved = test::turned(light, rotation);
        moved.centre *= scale;
        moved.halfU *= scale;
        moved.halfV *= scale;
        Shape shape;
        for (const Corners& t : triangles)
            shape.triangle(scale * (rotation * t.a), scale * (rotation * t.b),
                           scale * (rotation * t.c));
        std::vector<glm::dvec3> at;
        for (const glm::vec3& p : points.position) at.push_back(scale * (rotation * glm::dvec3(p)));
        const Reference turned =
            exactOf(shape, test::pointGBuffer(at, rotation * glm::dvec3(0, 0, 1), moved), moved);
        for (std::size_t i = 0; i < at.size(); ++i)
            // Vertices and points are rounded to float anew, some 3e-7 of a light 0.016 wide, and
            // a dozen edges cross it.
            ASSERT_NEAR(turned.visibility[i], truth.visibility[i], 3e-4) << scale;
    }
}

TEST(ExactHardCases, PointLightIsSeenOrNot) {
    const AreaLight point = lightAbove(4.0, 0.0, 0.0);
    AreaLight tiny = point;
    tiny.halfU = tiny.halfV = 1e-6;
    const Shape shape = shapeOf(soup(120, 23));
    const GBuffer points = floorPoints(48, point);
    const Reference hard = exactOf(shape, points, point), soft = exactOf(shape, points, tiny);
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    const Reference rays = traceReference(tracer, points, point, {});
    int hidden = 0, onAnEdge = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (soft.visibility[i] != 0.0f && soft.visibility[i] != 1.0f) {
            ++onAnEdge;
            continue;
        }
        ASSERT_EQ(hard.visibility[i], soft.visibility[i]) << i;
        ASSERT_EQ(hard.visibility[i], rays.visibility[i]) << i;
        ASSERT_EQ(hard.rays[i], 0.0f);
        hidden += hard.visibility[i] == 0.0f;
    }
    EXPECT_LT(onAnEdge, 3);
    EXPECT_GT(hidden, 500);
    EXPECT_LT(hidden, 2000);
}

TEST(ExactHardCases, LightOfNoWidthIsTheLimitOfANarrowOne) {
    AreaLight line = lightAbove(4.0, 1.0, 0.0);
    Shape shape;
    shape.rectangle({0.05, -3}, {3, 3}, 2.0);
    EXPECT_NEAR(exactAt(shape, {0, 0, 0}, line), 0.6, kTolerance);
    line.halfV = 0.5;
    line.halfU = 0.0;
    EXPECT_NEAR(exactAt(shape, {0, 0, 0}, line), 1.0, kTolerance);
    EXPECT_NEAR(exactAt(shape, {0.2, 0, 0}, line), 0.0, kTolerance);
}

TEST(ExactHardCases, AlphaMaskedCastersAreRefusedByName) {
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape shape;
    shape.rectangle({0, 0}, {1, 1}, 2.0);
    std::vector<Material> materials(2);
    materials[1].name = "leaf";
    materials[1].masked = true;
    auto geometry = std::make_shared<Geometry>(*shape.geometry());
    const GBuffer points = floorPoints(4, light);
    const Tracer opaque(geometry, materials, test::kNoImages);
    EXPECT_NO_THROW(exactReference(opaque, materials, points, light)) << "no triangle is of it";
    geometry->parts[0].material = 1;
    const Tracer masked(geometry, materials, test::kNoImages);
    try {
        exactReference(masked, materials, points, light);
        FAIL() << "not refused";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("'leaf' is alpha-masked"), std::string::npos)
            << error.what();
    }
}

TEST(ExactHardCases, PixelsAboveTheCapAreTracedAndFlagged) {
    const AreaLight light = lightAbove(4.0, 1.6, 1.2);
    const GBuffer points = floorPoints(24, light);
    const Shape shape = shapeOf(soup(60, 29));
    ExactStats all, some;
    const Reference exact = exactOf(shape, points, light, {}, &all);
    EXPECT_EQ(all.tracedPixels, 0u);
    EXPECT_EQ(all.exactPixels, points.size());
    ExactOptions options;
    options.maxEdges = 30;
    double last = -1.0;
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    const Reference mixed = exactReference(
        tracer, test::kOpaque, points, light, options, [&](double done) { last = done; }, &some);
    EXPECT_EQ(last, 1.0);
    std::size_t traced = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (mixed.rays[i] == 0.0f) {
            EXPECT_EQ(mixed.visibility[i], exact.visibility[i]);
            EXPECT_EQ(mixed.standardError[i], 0.0f);
            continue;
        }
        ++traced;
        EXPECT_GT(mixed.standardError[i], 0.0f);
        EXPECT_NEAR(mixed.visibility[i], exact.visibility[i], 8e-3);
    }
    EXPECT_EQ(traced, some.tracedPixels);
    EXPECT_EQ(points.size() - traced, some.exactPixels);
    EXPECT_GT(traced, 20u);
    EXPECT_LT(traced, points.size());
}

TEST(ExactHardCases, BackgroundAndPixelsFacingAwayAreNotAsked) {
    const AreaLight light = lightAbove(4.0, 1.0, 1.0);
    Shape shape;
    shape.rectangle({-3, -3}, {3, 3}, 2.0);
    GBuffer points = floorPoints(2, light);
    points.mask[0] = PixelClass::background;
    points.mask[1] = PixelClass::facingAway;
    const Reference exact = exactOf(shape, points, light);
    EXPECT_EQ(exact.visibility, (std::vector<float>{1.0f, 0.0f, 0.0f, 0.0f}));
    EXPECT_EQ(exact.irradiance, (std::vector<float>(4, 0.0f)));
}

}  // namespace
}  // namespace penumbra
