// Both references against the closed forms of METHODS.md R2. Every case prints the line of
// docs/TRUTH.md that it is.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "harness/reference/certificate.hpp"
#include "tests/analytic/exact_support.hpp"
#include "tests/support/closed_forms.hpp"

namespace penumbra {
namespace {

using closed_form::Rect;
using test::lightAbove;
using test::Shape;
using Truth = std::function<double(const glm::dvec3&)>;

constexpr int kSize = 128;
constexpr double kTarget = ReferenceOptions{}.targetStandardError;
/// Points, vertices and results are floats: 6e-8 of coordinates of some metres, magnified some
/// times onto the light.
constexpr double kRounding = 2e-6;

/// Exact visibility within kRounding of the closed form, and the traced reference as
/// Certificate demands. `meshError`: by how much the mesh itself is off the form.
void certify(const char* name, const Shape& casters, const GBuffer& gbuffer, const AreaLight& light,
             const Truth& truth, double meshError = 0.0) {
    const Tracer tracer(casters.geometry(), test::kOpaque, test::kNoImages);
    const Reference traced = traceReference(tracer, gbuffer, light, {});
    const Reference exact = exactReference(tracer, test::kOpaque, gbuffer, light);
    Certificate certificate;
    double exactWorst = 0.0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        ASSERT_EQ(gbuffer.mask[i], PixelClass::scored);
        ASSERT_EQ(exact.rays[i], 0.0f);
        const double expected = truth(glm::dvec3(gbuffer.position[i]));
        exactWorst = std::max(exactWorst, std::abs(exact.visibility[i] - expected));
        certificate.add(expected, traced.visibility[i], traced.standardError[i]);
    }
    ASSERT_GT(certificate.pixels, static_cast<int>(gbuffer.size()) / 25);
    fmt::print("| {} | {} | {:.1e} | {:.2f} | {:.1f} % | {:.2f} | {:.4f} |\n", name,
               certificate.pixels, exactWorst, certificate.rmse() / kTarget,
               100 * certificate.coverage(), std::sqrt(certificate.meanSquare()),
               certificate.worst);
    EXPECT_LE(exactWorst, kRounding + meshError);
    EXPECT_LE(certificate.rmse(), Certificate::kMostRmse * kTarget + meshError);
    EXPECT_LE(certificate.worst, Certificate::kMostError);
    EXPECT_GE(certificate.coverage(), Certificate::kLeastCoverage);
    EXPECT_LE(certificate.coverage(), Certificate::kMostCoverage);
    // 15/13 of 16 replicates. Pixels side by side are independent, and Student's t makes this mean
    // over thousands known to 3 %; stopping on a lucky spread raises it a little, the floor under
    // the error of edges along the light's sides lowers it by up to a half.
    EXPECT_LT(certificate.meanSquare(), 1.15 * Certificate::kMeanSquare);
    EXPECT_GT(certificate.meanSquare(), 0.5 * Certificate::kMeanSquare);
}

/// The plane z = 0 around the origin.
GBuffer floor(double halfWidth, const AreaLight& light, int size = kSize) {
    return test::planeGBuffer(size, size, {-halfWidth, -halfWidth, 0}, {2 * halfWidth, 0, 0},
                              {0, 2 * halfWidth, 0}, light);
}

Rect rectOf(const AreaLight& light) {
    return {{-light.halfU, -light.halfV}, {light.halfU, light.halfV}};
}

TEST(ClosedForm, KnownValues) {
    // METHODS.md R2's own examples, and agreement between the forms.
    const Rect occluder{{-0.4, -0.2}, {0.35, 0.6}}, light{{-1, -0.5}, {1, 0.5}};
    EXPECT_NEAR(closed_form::rectangle({0, 0}, occluder, 2, light, 5), 0.0625, 1e-12);
    EXPECT_NEAR(closed_form::rectangle({1.1, 0.2}, occluder, 2, light, 5), 0.8875, 1e-12);
    EXPECT_NEAR(closed_form::discBeside(-0.6870, 1.0), 0.1, 1e-4);
    EXPECT_NEAR(closed_form::discBeside(-0.8054, 1.0), 0.05, 1e-4);
    EXPECT_NEAR(closed_form::discBeside(0.3, 1.0), 1.0 - closed_form::discBeside(-0.3, 1.0), 1e-12);
    for (double x = -2.0; x < 2.0; x += 0.1) {
        const double half = closed_form::halfPlane(x, 0.2, 2, 2, 5);
        EXPECT_NEAR(half, closed_form::rectangle({x, 0}, {{0.2, -50}, {50, 50}}, 2, light, 5),
                    1e-12);
        EXPECT_NEAR(half,
                    closed_form::straightEdge({x, 0, 0}, {0.2, 0, 2}, {0.2, 1, 2}, {-9, 0, 2},
                                              lightAbove(5, 2, 1)),
                    1e-12);
    }
}

TEST(ClosedForm, LensesOfDiscsThatTouch) {
    // METHODS.md, hard case 50: to a step of float on either side of both tangencies.
    for (const auto& [r, R] : {std::pair(0.3, 1.1), {1.1, 0.3}, {1.0, 1.0}, {1e-9, 1.0}}) {
        const double whole = std::numbers::pi * std::min(r, R) * std::min(r, R);
        for (const double tangency : {std::abs(R - r), R + r})
            for (const double apart :
                 {std::nextafter(tangency, 0.0), tangency, std::nextafter(tangency, 9.0)}) {
                const double area = closed_form::lens(apart, r, R);
                // The area follows the distance to a tangency to the power 3/2, and a step of
                // float of the larger radius is at most 2e-7 of the smaller.
                EXPECT_NEAR(area, tangency < R + r ? whole : 0.0, 1e-7 * whole) << r << ' ' << R;
                EXPECT_GE(area, 0.0) << r << ' ' << R;
                EXPECT_LE(area, whole * (1.0 + 1e-12));
            }
    }
    EXPECT_DOUBLE_EQ(closed_form::lens(0.0, 1.0, 1.0), std::numbers::pi);
}

TEST(ClosedForm, RectangleOverRectangle) {
    const AreaLight light = lightAbove(5, 2, 1);
    const Rect occluder{{-0.4, -0.2}, {0.35, 0.6}};
    Shape casters;
    casters.rectangle(occluder.lo, occluder.hi, 2.0);
    certify("R2.1 rectangle over rectangle", casters, floor(2.5, light), light,
            [&](const glm::dvec3& p) {
                return closed_form::rectangle(glm::dvec2(p), occluder, 2.0, rectOf(light), 5.0);
            });
}

TEST(ClosedForm, HalfPlane) {
    const AreaLight light = lightAbove(4, 1.5, 1.5);
    Shape casters;
    casters.rectangle({0.1, -3}, {3, 3}, 1.5);
    certify("R2.2 half-plane", casters, floor(1.0, light), light,
            [&](const glm::dvec3& p) { return closed_form::halfPlane(p.x, 0.1f, 1.5, 1.5, 4.0); });
}

/// A plate in z = 3 with a round hole makes a disc of a square light in z = 4. The polygon in the
/// circle has 1024 corners and lacks 1 - sin(2 pi/n) / (2 pi/n) = 6e-6 of its area.
struct DiscLight {
    static constexpr int kCorners = 1024;
    static constexpr double kHeight = 4.0, kPlate = 3.0, kHole = 0.3;
    static constexpr double kRadius = kHole * kHeight / kPlate;
    static constexpr double kLacking = 6.3e-6;
    const AreaLight light = lightAbove(kHeight, 1.2, 1.2);
    Shape casters;

    DiscLight() {
        for (int i = 0; i < kCorners; ++i)
            casters.quad(onCircle({0, 0, kPlate}, kHole, i), onCircle({0, 0, kPlate}, 2.5, i),
                         onCircle({0, 0, kPlate}, 2.5, i + 1),
                         onCircle({0, 0, kPlate}, kHole, i + 1));
    }
    static glm::dvec3 onCircle(const glm::dvec3& centre, double radius, int i) {
        const double angle = 2 * std::numbers::pi * i / kCorners;
        return centre + radius * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
    }
    /// Where the hole's centre lies on the light, seen from p.
    static glm::dvec2 centreOn(const glm::dvec3& p) {
        return glm::dvec2(p) * (1.0 - kHeight / kPlate);
    }
    double area() const { return std::numbers::pi * kRadius * kRadius; }
};

TEST(ClosedForm, HalfPlaneUnderADisc) {
    DiscLight disc;
    const double edge = 0.05, h = 1.5;
    disc.casters.rectangle({edge, -3}, {3, 3}, h);
    certify(
        "R2.3 half-plane, disc light", disc.casters, floor(0.45, disc.light, 64), disc.light,
        [&](const glm::dvec3& p) {
            const double onLight = p.x + (edge - p.x) * disc.kHeight / h;
            return closed_form::discBeside(onLight - disc.centreOn(p).x, disc.kRadius) *
                   disc.area() / disc.light.area();
        },
        disc.kLacking);
}

TEST(ClosedForm, ObliqueEdgeOverATiltedReceiver) {
    const AreaLight light = lightAbove(4, 1.2, 0.8);
    const glm::dvec3 a(-5, -2.75, 1.55), b(5, 2.75, 2.45), far(3, -7, 2.0);
    Shape casters;
    casters.triangle(a, b, far);
    const GBuffer receiver = test::planeGBuffer(kSize, kSize, {-1.2, -1.0, -0.2}, {2.4, 0, 0.5},
                                                {0.1, 2.0, -0.3}, light);
    certify("R2.4 oblique edge, tilted receiver", casters, receiver, light,
            [&](const glm::dvec3& p) {
                return closed_form::straightEdge(p, glm::dvec3(glm::vec3(a)),
                                                 glm::dvec3(glm::vec3(b)), {-3, 7, 2}, light);
            });
}

TEST(ClosedForm, StripWithoutUmbra) {
    const AreaLight light = lightAbove(4.0, 1.2, 0.7);
    const Rect strip{{-0.1, -4}, {0.1, 4}};  // (Wo H - w h) / (H - h) < 0
    Shape casters;
    casters.rectangle(strip.lo, strip.hi, 1.0);
    certify("R2.5 strip without umbra", casters, floor(0.6, light), light,
            [&](const glm::dvec3& p) {
                return closed_form::rectangle(glm::dvec2(p), strip, 1.0, rectOf(light), 4.0);
            });
}

TEST(ClosedForm, DiscOverDisc) {
    DiscLight disc;
    const glm::dvec3 centre(0.05, 0, 1.0);
    const double radius = 0.12;
    for (int i = 0; i < disc.kCorners; ++i)
        disc.casters.triangle(centre, disc.onCircle(centre, radius, i),
                              disc.onCircle(centre, radius, i + 1));
    certify(
        "R2.6 disc over disc", disc.casters, floor(0.4, disc.light, 64), disc.light,
        [&](const glm::dvec3& p) {
            const double m = disc.kHeight / centre.z;
            const glm::dvec2 onLight = glm::dvec2(p) + glm::dvec2(centre - p) * m;
            const double apart = glm::length(onLight - disc.centreOn(p));
            return (disc.area() - closed_form::lens(apart, radius * m, disc.kRadius)) /
                   disc.light.area();
        },
        2 * disc.kLacking);
}

TEST(ClosedForm, Sphere) {
    // The mesh holds the sphere of radius r sqrt(1 - pi^2 / (2 n^2)) and is held by that of radius
    // r (tests/analytic/exact_test.cpp): between them lie at most 2 pi^2 / (4 n^2) of the hidden
    // part, doubled because obliquely seen ellipses are longer.
    const int n = 300;
    const double meshError = std::numbers::pi * std::numbers::pi / (n * n);
    const glm::dvec3 centre(0.0, 0.1, 1.5);
    const AreaLight light = lightAbove(4.0, 3.0, 2.4);
    Shape casters;
    casters.sphere(centre, 0.5, n);
    certify(
        "R2.7 sphere", casters, floor(2.0, light, 64), light,
        [&](const glm::dvec3& p) {
            // 2e4 nodes give 1e-6 (METHODS.md R2.7).
            return closed_form::besideSphere(p, centre, 0.5, light, 20000);
        },
        meshError);
}

TEST(ClosedForm, TwoHeights) {
    const AreaLight light = lightAbove(5.0, 2.0, 1.4);
    const Rect low{{-0.3, -0.3}, {0.2, 0.15}}, high{{-0.5, -0.1}, {0.4, 0.5}};
    Shape casters;
    casters.rectangle(low.lo, low.hi, 1.0);
    casters.rectangle(high.lo, high.hi, 3.0);
    certify("R2.8 two heights, overlapping", casters, floor(1.5, light), light,
            [&](const glm::dvec3& p) {
                return closed_form::twoRectangles(glm::dvec2(p), low, 1.0, high, 3.0, rectOf(light),
                                                  5.0);
            });
}

TEST(ClosedForm, CoplanarOccludersAddOrUnite) {
    const AreaLight light = lightAbove(5, 2, 2);
    const Rect a{{-0.7, -0.5}, {-0.1, 0.4}};
    const std::pair<const char*, Rect> others[] = {
        {"R2.9 coplanar, disjoint", {{0.1, -0.3}, {0.6, 0.7}}},
        {"R2.9 coplanar, overlapping", {{-0.4, -0.2}, {0.6, 0.7}}}};
    for (const auto& [name, b] : others) {
        Shape casters;
        casters.rectangle(a.lo, a.hi, 2.0);
        casters.rectangle(b.lo, b.hi, 2.0);
        certify(name, casters, floor(2.5, light), light, [&, &b = b](const glm::dvec3& p) {
            return closed_form::twoRectangles(glm::dvec2(p), a, 2.0, b, 2.0, rectOf(light), 5.0);
        });
    }
}

TEST(ClosedForm, TwoLayersOfTheExactnessTable) {
    // Rectangles in z = 1 and z = 2 that hide [lo, hi] of a unit light in z = 4 from the origin; as
    // many pixels there as make statistics.
    struct Arrangement {
        const char* name;
        Rect one, two;
        double truth;
    };
    const Arrangement arrangements[] = {
        {"R2.10 nested: max", {{0.1, 0.1}, {0.9, 0.6}}, {{0.3, 0.2}, {0.7, 0.5}}, 0.6},
        {"R2.10 disjoint: sum", {{0.1, 0.1}, {0.4, 0.6}}, {{0.5, 0.2}, {0.9, 0.8}}, 0.61},
        {"R2.10 orthogonal: product", {{-9, -9}, {0.3, 9}}, {{-9, -9}, {9, 0.55}}, 0.315},
        {"R2.10 one layer empty", {{2, 2}, {3, 3}}, {{0.2, 0.1}, {0.7, 0.5}}, 0.8},
    };
    const AreaLight light = lightAbove(4, 1, 1);
    for (const Arrangement& each : arrangements) {
        Shape casters;
        casters.rectangle((each.one.lo - 0.5) / 4.0, (each.one.hi - 0.5) / 4.0, 1.0);
        casters.rectangle((each.two.lo - 0.5) / 2.0, (each.two.hi - 0.5) / 2.0, 2.0);
        const GBuffer points =
            test::pointGBuffer(std::vector<glm::dvec3>(1024, glm::dvec3(0.0)), {0, 0, 1}, light);
        certify(each.name, casters, points, light, [&](const glm::dvec3&) { return each.truth; });
    }
}

TEST(ClosedForm, HoldsAtAnyScale) {
    for (const double scale : {1e-3, 1e3}) {
        const AreaLight light = lightAbove(5 * scale, 2 * scale, 1 * scale);
        const Rect occluder{{-0.4 * scale, -0.2 * scale}, {0.35 * scale, 0.6 * scale}};
        Shape casters;
        casters.rectangle(occluder.lo, occluder.hi, 2.0 * scale);
        certify(
            scale < 1 ? "R2.12 R2.1 a thousandth the size" : "R2.12 R2.1 a thousand times the size",
            casters, floor(2.5 * scale, light), light, [&](const glm::dvec3& p) {
                return closed_form::rectangle(glm::dvec2(p), occluder, 2.0 * scale, rectOf(light),
                                              5.0 * scale);
            });
    }
}

}  // namespace
}  // namespace penumbra
