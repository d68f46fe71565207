// exactReference against the closed forms of METHODS.md R2.
//
// Points, vertices and results are floats: 6e-8 of coordinates of some metres, magnified some times
// onto the light. exactReference itself adds 1e-12.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/analytic/exact_support.hpp"
#include "tests/support/closed_forms.hpp"

namespace penumbra {
namespace {

using closed_form::Rect;
using test::exactAt;
using test::exactOf;
using test::lightAbove;
using test::Shape;

constexpr double kTolerance = 2e-6;

/// The light's rectangle in its own plane, for closed forms.
Rect rectOf(const AreaLight& light) {
    return {{-light.halfU, -light.halfV}, {light.halfU, light.halfV}};
}

TEST(Exact, RectangleOverRectangle) {
    const AreaLight light = lightAbove(5.0, 2.0, 1.0);
    const Rect caster{{-0.4, -0.2}, {0.35, 0.6}};
    Shape shape;
    shape.rectangle(caster.lo, caster.hi, 2.0);
    EXPECT_NEAR(exactAt(shape, {0, 0, 0}, light), 0.0625, kTolerance);
    EXPECT_NEAR(exactAt(shape, {1.1, 0.2, 0}, light), 0.8875, kTolerance);

    const GBuffer points = test::planeGBuffer(64, 64, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, light);
    const Reference exact = exactOf(shape, points, light);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec2 p(points.position[i]);
        ASSERT_NEAR(exact.visibility[i], closed_form::rectangle(p, caster, 2.0, rectOf(light), 5.0),
                    kTolerance)
            << p.x << ' ' << p.y;
        ASSERT_EQ(exact.standardError[i], 0.0f);
        ASSERT_EQ(exact.rays[i], 0.0f);
    }
}

TEST(Exact, CoupledIrradianceOfARectangleIsThatOfTheLightWithoutItsImage) {
    // The caster's image on the light is a rectangle, and so another light.
    const AreaLight light = lightAbove(3.0, 2.0, 2.0);
    const Rect caster{{-0.2, -0.3}, {0.35, 0.25}};
    Shape shape;
    shape.rectangle(caster.lo, caster.hi, 2.0);
    const glm::dvec3 upright(0, 0, 1), leaning = glm::normalize(glm::dvec3(1.0, 0.2, 0.1));
    for (const glm::dvec3& normal : {upright, leaning}) {
        std::vector<glm::dvec3> at;
        for (double x = -0.6; x <= 0.6; x += 0.1) at.push_back({x, 0.15 - 0.3 * x, 0.0});
        const GBuffer points = test::pointGBuffer(at, normal, light);
        EXPECT_EQ(points.mask[0], normal == upright ? PixelClass::scored : PixelClass::horizon);
        const Reference exact = exactOf(shape, points, light);
        for (std::size_t i = 0; i < at.size(); ++i) {
            const Rect image = closed_form::intersection(
                closed_form::projected(caster, glm::dvec2(at[i]), 2.0, 3.0), rectOf(light));
            ASSERT_GT(image.area(), 0.0);
            AreaLight hidden = light;
            hidden.centre = glm::dvec3(0.5 * (image.lo + image.hi), 3.0);
            hidden.halfU = 0.5 * (image.hi.x - image.lo.x);
            hidden.halfV = 0.5 * (image.hi.y - image.lo.y);
            const double whole = unshadowedIrradiance(at[i], normal, light);
            EXPECT_NEAR(exact.irradiance[i], whole - unshadowedIrradiance(at[i], normal, hidden),
                        kTolerance * whole)
                << "x = " << at[i].x;
        }
    }
}

TEST(Exact, HalfPlane) {
    const AreaLight light = lightAbove(4.0, 1.0, 0.6);
    Shape shape;
    shape.rectangle({0.1, -3.0}, {3.0, 3.0}, 1.5);
    for (double x = -0.6; x < 1.0; x += 0.037)
        EXPECT_NEAR(exactAt(shape, {x, 0.2, 0}, light),
                    closed_form::halfPlane(x, 0.1, 1.5, 1.0, 4.0), kTolerance)
            << x;
}

TEST(Exact, StraightEdgeOverAnyReceiverAndLight) {
    // The edge is one side of a triangle that is large, but not so large that float vertices would
    // bend it; everything is turned at random.
    const AreaLight upright = lightAbove(4.0, 1.6, 0.9);
    int partial = 0;
    for (int k = 0; k < 60; ++k) {
        const glm::dmat3 rotation = test::turn({std::sin(k), std::cos(2.1 * k), 0.4}, 0.7 * k);
        const AreaLight light = test::turned(upright, rotation);
        const double angle = 0.37 * k;
        const glm::dvec3 along =
            glm::normalize(glm::dvec3(std::cos(angle), std::sin(angle), 0.6 * std::sin(1.3 * k)));
        const glm::dvec3 aside =
            glm::normalize(glm::dvec3(-std::sin(angle), std::cos(angle), 0.5 * std::cos(0.9 * k)));
        const glm::dvec3 on(0.25 * std::sin(1.7 * k), 0.25 * std::cos(2.3 * k), 2.0);
        const glm::dvec3 a = rotation * (on - 4.0 * along), b = rotation * (on + 4.0 * along),
                         c = rotation * (on + 4.0 * aside);
        Shape shape;
        shape.triangle(a, b, c);
        // A receiver that leans, still with the whole light above it.
        const glm::dvec3 normal =
            rotation * glm::normalize(glm::dvec3(0.5 * std::sin(k), 0.5 * std::cos(k), 1.0));
        const glm::dvec3 p = rotation * glm::dvec3(0.1 * std::cos(k), 0.05, 0.0);
        const GBuffer points = test::pointGBuffer({p}, normal, light);
        ASSERT_EQ(points.mask[0], PixelClass::scored);
        const double truth = closed_form::straightEdge(p, a, b, p + (p - c), light);
        EXPECT_NEAR(exactOf(shape, points, light).visibility[0], truth, kTolerance) << k;
        partial += truth > 0.02 && truth < 0.98;
    }
    EXPECT_GT(partial, 30) << "the edges should cross the light";
}

TEST(Exact, StripUmbraAndGreatestOcclusion) {
    const double H = 4.0, h = 1.0, w = 1.2;
    const AreaLight light = lightAbove(H, w, 0.7);
    // Wide enough for an umbra of (Wo H - w h)/(H - h).
    const double wide = 0.6, umbra = (wide * H - w * h) / (H - h);
    Shape broad, narrow;
    broad.rectangle({-0.5 * wide, -2.0}, {0.5 * wide, 2.0}, h);
    EXPECT_EQ(exactAt(broad, {0.5 * umbra - 1e-3, 0, 0}, light), 0.0);
    EXPECT_NEAR(exactAt(broad, {0.5 * umbra + 1e-2, 0, 0}, light), 1e-2 * (H - h) / h / w,
                kTolerance);
    narrow.rectangle({-0.1, -2.0}, {0.1, 2.0}, h);
    EXPECT_NEAR(exactAt(narrow, {0, 0, 0}, light), 1.0 - 0.2 * (H / h) / w, kTolerance);
}

TEST(Exact, OverlappingRectanglesAtDifferentHeights) {
    const AreaLight light = lightAbove(5.0, 2.0, 1.4);
    const Rect low{{-0.3, -0.3}, {0.2, 0.15}}, high{{-0.5, -0.1}, {0.4, 0.5}};
    Shape shape;
    shape.rectangle(low.lo, low.hi, 1.0);
    shape.rectangle(high.lo, high.hi, 3.0);
    int overlapping = 0;
    const GBuffer points = test::planeGBuffer(48, 48, {-1.5, -1.5, 0}, {3, 0, 0}, {0, 3, 0}, light);
    const Reference exact = exactOf(shape, points, light);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec2 p(points.position[i]);
        ASSERT_NEAR(exact.visibility[i],
                    closed_form::twoRectangles(p, low, 1.0, high, 3.0, rectOf(light), 5.0),
                    kTolerance);
        overlapping += closed_form::intersection(closed_form::projected(low, p, 1.0, 5.0),
                                                 closed_form::projected(high, p, 3.0, 5.0))
                           .area() > 0.0;
    }
    EXPECT_GT(overlapping, 100);
}

TEST(Exact, CoplanarRectanglesDisjointAndOverlapping) {
    const AreaLight light = lightAbove(4.0, 1.5, 1.5);
    const Rect a{{-0.4, -0.3}, {0.0, 0.2}}, beside{{0.1, -0.2}, {0.4, 0.3}},
        over{{-0.15, -0.2}, {0.3, 0.3}};
    for (const Rect& b : {beside, over}) {
        Shape shape;
        shape.rectangle(a.lo, a.hi, 1.5);
        shape.rectangle(b.lo, b.hi, 1.5);
        for (double x = -0.5; x < 0.6; x += 0.11)
            EXPECT_NEAR(
                exactAt(shape, {x, 0.3 * x, 0}, light),
                closed_form::twoRectangles({x, 0.3 * x}, a, 1.5, b, 1.5, rectOf(light), 4.0),
                kTolerance);
    }
}

/// Rectangles in the planes z = 1 and z = 2 that cover [lo, hi] of a unit light at H = 4 in its
/// own (x, y) in [0, 1], as the origin sees it.
class TwoLayers {
  public:
    TwoLayers& layer(double z, glm::dvec2 lo, glm::dvec2 hi) {
        shape_.rectangle((lo - 0.5) * (z / 4.0), (hi - 0.5) * (z / 4.0), z);
        return *this;
    }
    double visibility() const { return exactAt(shape_, {0, 0, 0}, lightAbove(4.0, 1.0, 1.0)); }

  private:
    Shape shape_;
};

TEST(Exact, TwoLayersOfTheExactnessTable) {
    // Nested: the maximum.
    EXPECT_NEAR(
        TwoLayers().layer(1, {0.1, 0.1}, {0.9, 0.6}).layer(2, {0.3, 0.2}, {0.7, 0.5}).visibility(),
        1.0 - 0.8 * 0.5, kTolerance);
    // Disjoint: the sum.
    EXPECT_NEAR(
        TwoLayers().layer(1, {0.1, 0.1}, {0.4, 0.6}).layer(2, {0.5, 0.2}, {0.9, 0.8}).visibility(),
        1.0 - 0.3 * 0.5 - 0.4 * 0.6, kTolerance);
    // Orthogonal half-planes: the product.
    EXPECT_NEAR(TwoLayers().layer(1, {-9, -9}, {0.3, 9}).layer(2, {-9, -9}, {9, 0.55}).visibility(),
                0.315, kTolerance);
    // One layer empty, then one full.
    EXPECT_NEAR(TwoLayers().layer(1, {2, 2}, {3, 3}).layer(2, {0.2, 0.1}, {0.7, 0.5}).visibility(),
                1.0 - 0.5 * 0.4, kTolerance);
    EXPECT_EQ(TwoLayers().layer(1, {-1, -1}, {2, 2}).layer(2, {0.2, 0.1}, {0.7, 0.5}).visibility(),
              0.0);
}

glm::dvec3 onCircle(const glm::dvec3& centre, double radius, int i, int n) {
    const double angle = 2 * std::numbers::pi * i / n;
    return centre + radius * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
}

TEST(Exact, DiscOverDisc) {
    // A plate with a round hole makes a disc of the square light; a polygon of n corners in the
    // circle lacks 1 - sin(2 pi/n)/(2 pi/n) of its area.
    const int n = 1024;
    const double H = 4.0, stopZ = 3.0, hole = 0.3, discZ = 1.0, disc = 0.12;
    const double lacking = 1.0 - std::sin(2 * std::numbers::pi / n) / (2 * std::numbers::pi / n);
    const AreaLight light = lightAbove(H, 1.2, 1.2);
    Shape shape;
    for (int i = 0; i < n; ++i) {
        const auto corner = [&](int k) { return onCircle({0, 0, stopZ}, hole, k, n); };
        const auto outside = [&](int k) { return onCircle({0, 0, stopZ}, 1.5, k, n); };
        shape.quad(corner(i), outside(i), outside(i + 1), corner(i + 1));
        shape.triangle({0.05, 0, discZ}, onCircle({0.05, 0, discZ}, disc, i, n),
                       onCircle({0.05, 0, discZ}, disc, i + 1, n));
    }
    for (double x = -0.25; x < 0.3; x += 0.05) {
        const double stopRadius = hole * H / stopZ, discRadius = disc * H / discZ;
        const double stopX = x - x * H / stopZ, discX = x + (0.05 - x) * H / discZ;
        ASSERT_LT(std::abs(stopX) + stopRadius, 0.6) << "the disc is on the light";
        const double stopArea = std::numbers::pi * stopRadius * stopRadius;
        const double discArea = std::numbers::pi * discRadius * discRadius;
        const double truth =
            stopArea - closed_form::lens(std::abs(discX - stopX), discRadius, stopRadius);
        EXPECT_NEAR(exactAt(shape, {x, 0, 0}, light), truth / light.area(),
                    lacking * (stopArea + discArea) / light.area() + kTolerance)
            << x;
    }
}

TEST(Exact, SphereLiesBetweenItsMeshesInnerAndOuterSphere) {
    // The mesh's vertices are on the sphere. Its triangles are half cells of pi/n by at most pi/n
    // radians, so their circumscribed circles have radii of at most pi/n / sqrt(2), and the mesh
    // holds the sphere of radius r sqrt(1 - pi^2 / (2 n^2)).
    constexpr int kNodes = 200000;
    const int n = 96;
    const double radius = 0.5;
    const double inner =
        radius * std::sqrt(1.0 - std::numbers::pi * std::numbers::pi / (2.0 * n * n));
    const glm::dvec3 centre(0.0, 0.1, 1.5);
    const AreaLight light = lightAbove(4.0, 3.0, 2.4);
    Shape shape;
    shape.sphere(centre, radius, n);
    // On axis first: rho = H r / sqrt(h^2 - r^2), the ellipse a circle.
    const double rho = 4.0 * radius / std::sqrt(1.5 * 1.5 - radius * radius);
    EXPECT_NEAR(
        closed_form::besideSphere({0, 0.1, 0}, centre, radius, lightAbove(4.0, 4.0, 4.0), kNodes),
        1.0 - std::numbers::pi * rho * rho / 16.0, 1e-6);
    for (double x = -1.2; x < 1.3; x += 0.2) {
        const glm::dvec3 p(x, -0.3, 0.0);
        const double outerV = closed_form::besideSphere(p, centre, radius, light, kNodes);
        const double innerV = closed_form::besideSphere(p, centre, inner, light, kNodes);
        const double v = exactAt(shape, p, light);
        EXPECT_GE(v, outerV - kTolerance) << x;
        EXPECT_LE(v, innerV + kTolerance) << x;
    }
}

}  // namespace
}  // namespace penumbra
