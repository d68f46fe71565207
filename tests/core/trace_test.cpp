#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/sampling/sampling.hpp"
#include "core/trace/alpha_mask.hpp"
#include "core/trace/tracer.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

/// A sequence of numbers in [0, 1).
class Numbers {
  public:
    double operator()() { return toUnitFloat(hash(17u, next_++)); }

  private:
    std::uint32_t next_ = 0;
};

/// Points on every triangle of `shape`, rounded to float as a G-buffer's are, each with rays into
/// the hemisphere above: how many are blocked within `reach`.
int selfHits(const test::Shape& shape, double reach, bool bothSides) {
    const auto geometry = shape.geometry();
    const Tracer tracer(geometry, test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    Numbers number;
    int blocked = 0;
    const auto flush = [&] {
        stream.trace();
        for (std::size_t i = 0; i < stream.size(); ++i) blocked += stream.blocked(i);
        stream.clear();
    };
    for (std::size_t t = 0; t < geometry->triangleCount(); ++t) {
        const glm::dvec3 a(geometry->positions[geometry->indices[3 * t]]),
            b(geometry->positions[geometry->indices[3 * t + 1]]),
            c(geometry->positions[geometry->indices[3 * t + 2]]);
        const glm::dvec3 outward = glm::normalize(glm::cross(b - a, c - a));
        for (int sample = 0; sample < 32; ++sample) {
            double u = number(), v = number();
            if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
            const glm::dvec3 side = bothSides && sample % 2 ? -outward : outward;
            const glm::vec3 position((1 - u - v) * a + u * b + v * c), normal(side);
            const glm::vec3 origin = tracer.shadowOrigin(position, normal);
            // Down to a thousandth of a radian above the surface.
            const double elevation = std::pow(10.0, -3.0 * number());
            const double turn = 2 * std::numbers::pi * number();
            const glm::dvec3 tangent = glm::normalize(b - a), across = glm::cross(side, tangent);
            const glm::dvec3 direction =
                std::sin(elevation) * side +
                std::cos(elevation) * (std::cos(turn) * tangent + std::sin(turn) * across);
            stream.add(origin, glm::vec3(glm::dvec3(position) + reach * direction));
            if (stream.full()) flush();
        }
    }
    flush();
    return blocked;
}

TEST(Trace, ConvexBodyDoesNotShadowItsLitSideAtAnyScale) {
    for (const double scale : {1e-3, 1.0, 1e3}) {
        test::Shape sphere;
        sphere.sphere(glm::dvec3(0.0), scale, 24);
        EXPECT_EQ(selfHits(sphere, 10 * scale, false), 0) << "radius " << scale;
    }
}

TEST(Trace, ConvexBodyFarFromTheOriginDoesNotShadowItself) {
    // Coordinates up to 1e5 radii: float leaves 2^-7 of the radius, the offset follows.
    for (const double distance : {1e3, 1e5}) {
        test::Shape body;
        body.box(glm::dvec3(distance), glm::dvec3(distance + 10.0));
        EXPECT_EQ(selfHits(body, 100.0, false), 0) << "at " << distance;
    }
}

TEST(Trace, TiltedFlatSurfacesDoNotShadowThemselves) {
    for (int tilt = 0; tilt < 24; ++tilt) {
        const double a = 0.37 + 0.83 * tilt, b = 0.11 + 1.31 * tilt;
        const glm::dvec3 u(std::cos(a), std::sin(a) * std::cos(b), std::sin(a) * std::sin(b));
        const glm::dvec3 v =
            glm::normalize(glm::cross(u, glm::dvec3(std::sin(b), std::cos(b), 0.3)));
        for (const int n : {1, 16}) {
            // Long and thin as well as square: slivers have the worst-known planes.
            for (const double length : {2.0, 200.0}) {
                test::Shape plane;
                plane.grid(-0.5 * length * u - v, length * u, 2.0 * v, n);
                EXPECT_EQ(selfHits(plane, 2 * length, true), 0)
                    << "tilt " << tilt << ", " << n << " cells, length " << length;
            }
        }
    }
}

TEST(Trace, CreaseOfOneDegreeShadowsOnlyBelowItsSlope) {
    const double slope = std::numbers::pi / 180.0;
    test::Shape valley;  // flat for x < 0, rising by one degree for x > 0
    valley.quad({-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0});
    valley.quad({0, -1, 0}, {1, -1, std::tan(slope)}, {1, 1, std::tan(slope)}, {0, 1, 0});
    const Tracer tracer(valley.geometry(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 p(-1e-4f - 4e-3f * static_cast<float>(i), 0.3f, 0.0f);
        const glm::vec3 origin = tracer.shadowOrigin(p, {0, 0, 1});
        // From -x the far end of the slope appears under less than its slope: 0.4 of it is below.
        for (const double elevation : {0.4 * slope, 1.05 * slope}) {
            stream.clear();
            stream.add(origin, p + 3.0f * glm::vec3(std::cos(elevation), 0, std::sin(elevation)));
            stream.trace();
            EXPECT_EQ(stream.blocked(0), elevation < slope) << "x = " << p.x;
        }
    }
}

TEST(Trace, ContactShadowReachesTheFoot) {
    test::Shape shape;  // 10 m floor, a box standing on it
    shape.rectangle({-5, -5}, {5, 5}, 0.0);
    shape.box({0, -1, 0}, {1, 1, 2});
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    for (const float distance : {1e-4f, 1e-3f, 1e-2f, 0.1f}) {  // 1e-5 of the floor and up
        const glm::vec3 p(-distance, 0.0f, 0.0f);
        const glm::vec3 origin = tracer.shadowOrigin(p, {0, 0, 1});
        stream.clear();
        stream.add(origin, {10.0f, 0.0f, 10.0f});   // through the box
        stream.add(origin, {-10.0f, 0.0f, 10.0f});  // away from it
        stream.trace();
        EXPECT_TRUE(stream.blocked(0)) << distance;
        EXPECT_FALSE(stream.blocked(1)) << distance;
    }
}

TEST(Trace, LowSlabShadowsDownToAFewOffsets) {
    // A plate 1e-5 of the scene above the floor: 14 times the offset of 7e-7.
    test::Shape shape;
    shape.rectangle({-1, -1}, {1, 1}, 0.0);
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 1e-5);
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    stream.add(tracer.shadowOrigin({0.1f, 0.2f, 0.0f}, {0, 0, 1}), {0.3f, 0.1f, 2.0f});
    stream.add(tracer.shadowOrigin({0.1f, 0.2f, 1e-5f}, {0, 0, 1}), {0.3f, 0.1f, 2.0f});
    stream.trace();
    EXPECT_TRUE(stream.blocked(0));
    EXPECT_FALSE(stream.blocked(1));
}

TEST(Trace, OffsetScalesWithTheScene) {
    float relative[2];
    int k = 0;
    for (const double scale : {1.0, 1024.0}) {
        test::Shape shape;
        shape.rectangle({-scale, -scale}, {scale, scale}, 0.0);
        const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
        relative[k++] = tracer.shadowOrigin({0, 0, 0}, {0, 0, 1}).z / static_cast<float>(scale);
    }
    EXPECT_GT(relative[0], 0.0f);
    EXPECT_EQ(relative[0], relative[1]);
}

TEST(Trace, SurfacesInTheLightsPlaneDoNotOcclude) {
    test::Shape shape;
    shape.rectangle({-1, -1}, {1, 1}, 2.0);  // the ceiling the light is set into
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    stream.add({0, 0, 0}, {0.2f, 0.1f, 2.0f});
    stream.add({0, 0, 0}, {0.2f, 0.1f, 2.001f});  // ends 5e-4 of the way beyond it
    stream.trace();
    EXPECT_FALSE(stream.blocked(0));
    EXPECT_TRUE(stream.blocked(1));
}

TEST(Trace, StreamsAreReusable) {
    test::Shape shape;
    shape.rectangle({-1, -1}, {1, 1}, 1.0);
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    for (int round = 0; round < 2; ++round) {
        stream.clear();
        while (!stream.full()) {
            const float x = stream.size() % 2 == 0 ? 0.3f : 3.0f;
            stream.add({x, 0, 0}, {x, 0, 2});
        }
        stream.trace();
        for (std::size_t i = 0; i < stream.size(); ++i) EXPECT_EQ(stream.blocked(i), i % 2 == 0);
    }
}

TEST(Trace, FirstHitIsOnThePlaneToDoubleRoundingFromAnyDistance) {
    test::Shape shape;
    shape.quad({-1, -2, 0.3}, {1.5, -1, 0.7}, {1.2, 2, 1.1}, {-1.3, 1, 0.7});
    const auto geometry = shape.geometry();
    const Tracer tracer(geometry, test::kOpaque, test::kNoImages);
    Numbers number;
    for (const double distance : {1.0, 1e3, 1e6}) {
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 target(0.6 * number() - 0.3, 0.6 * number() - 0.3, 0.6);
            const glm::dvec3 direction =
                glm::normalize(glm::dvec3(number() - 0.5, number() - 0.5, -0.5));
            const glm::dvec3 origin = target - distance * direction;
            const SurfaceHit hit = tracer.firstHit(origin, direction, 0.0, 1e30);
            ASSERT_TRUE(hit.hit);
            const std::uint32_t* corner = &geometry->indices[3 * hit.triangle];
            const glm::dvec3 a(geometry->positions[corner[0]]), b(geometry->positions[corner[1]]),
                c(geometry->positions[corner[2]]);
            const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
            // A few roundings of coordinates as large as the distance.
            const double rounding = 8 * std::numeric_limits<double>::epsilon() * (1 + distance);
            EXPECT_LT(std::abs(glm::dot(normal, hit.position - a)), rounding);
            EXPECT_LT(glm::length(glm::cross(hit.position - origin, direction)), 4 * rounding);
            EXPECT_LT(glm::dot(glm::dvec3(hit.geometricNormal), direction), 0.0);
            EXPECT_GT(glm::dot(hit.geometricNormal, hit.shadingNormal), 0.0f);
            EXPECT_NEAR(glm::length(hit.geometricNormal), 1.0f, 1e-6f);
        }
    }
}

TEST(Trace, FirstHitKeepsToItsRangeAndFindsTheNearest) {
    test::Shape shape;
    shape.rectangle({-1, -1}, {1, 1}, 0.0);
    shape.rectangle({-1, -1}, {1, 1}, 1.0);
    const Tracer tracer(shape.geometry(), test::kOpaque, test::kNoImages);
    const glm::dvec3 origin(0.2, 0.1, 3.0), down(0, 0, -1);
    EXPECT_DOUBLE_EQ(tracer.firstHit(origin, down, 0.0, 1e30).position.z, 1.0);
    EXPECT_DOUBLE_EQ(tracer.firstHit(origin, down, 2.5, 1e30).position.z, 0.0);
    EXPECT_FALSE(tracer.firstHit(origin, down, 0.0, 1.5).hit);
    EXPECT_FALSE(tracer.firstHit(origin, down, 3.5, 1e30).hit);
    EXPECT_FALSE(tracer.firstHit(origin, -down, 0.0, 1e30).hit);
    EXPECT_FALSE(tracer.firstHit({5, 5, 3}, down, 0.0, 1e30).hit);
}

TEST(Trace, EmptyGeometryBlocksNothing) {
    const Tracer tracer(std::make_shared<Geometry>(), test::kOpaque, test::kNoImages);
    Tracer::Stream stream(tracer);
    stream.add({0, 0, 0}, {0, 0, 1});
    stream.trace();
    EXPECT_FALSE(stream.blocked(0));
    EXPECT_FALSE(tracer.firstHit({0, 0, 1}, {0, 0, -1}, 0, 1e30).hit);
}

/// 8 x 8 texels of hashed alpha.
TextureImage speckled(bool linear, Wrap wrap) {
    TextureImage image;
    image.width = image.height = 8;
    image.linear = linear;
    image.wrapS = image.wrapT = wrap;
    for (std::uint32_t i = 0; i < 64; ++i) {
        const auto alpha =
            static_cast<std::uint8_t>(i < 32 ? (i % 8 < 4 ? 255 : 0) : hash(i) >> 24);
        image.rgba.insert(image.rgba.end(), {200, 100, 50, alpha});
    }
    return image;
}

TEST(Trace, AlphaMaskSaysWhatBaseColorSays) {
    for (const bool linear : {false, true})
        for (const Wrap wrap : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge}) {
            const std::vector<TextureImage> images{speckled(linear, wrap)};
            Material material;
            material.masked = true;
            material.baseColorTexture = 0;
            material.baseColor.a = 0.9f;
            const AlphaMask mask(material, images);
            Numbers number;
            int present = 0;
            for (int i = 0; i < 20000; ++i) {
                const glm::vec2 uv(3.0 * number() - 1.0, 3.0 * number() - 1.0);
                const bool expected = baseColorAt(material, images, uv).a >= material.alphaCutoff;
                ASSERT_EQ(mask.present(uv), expected) << uv.x << ' ' << uv.y;
                present += expected;
            }
            EXPECT_GT(present, 2000);
            EXPECT_LT(present, 18000);
        }
}

TEST(Trace, MaskedSurfacesLetRaysThroughWhereTheyAreAbsent) {
    std::vector<TextureImage> images{speckled(false, Wrap::clampToEdge)};
    std::vector<Material> materials(1);
    materials[0].masked = true;
    materials[0].baseColorTexture = 0;
    test::Shape shape;
    shape.rectangle({0, 0}, {1, 1}, 1.0);
    const Tracer tracer(shape.geometry(), materials, images);
    Tracer::Stream stream(tracer);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            const glm::vec2 uv((static_cast<float>(x) + 0.4f) / 8,
                               (static_cast<float>(y) + 0.6f) / 8);
            const bool present = baseColorAt(materials[0], images, uv).a >= 0.5f;
            stream.clear();
            stream.add({uv.x, uv.y, 0.0f}, {uv.x, uv.y, 2.0f});
            stream.trace();
            EXPECT_EQ(stream.blocked(0), present) << x << ' ' << y;
            const SurfaceHit hit = tracer.firstHit({uv.x, uv.y, 2.0}, {0, 0, -1}, 0.0, 1e30);
            EXPECT_EQ(hit.hit, present);
            if (hit.hit) {
                EXPECT_NEAR(hit.uv.x, uv.x, 1e-6f);
                EXPECT_NEAR(hit.uv.y, uv.y, 1e-6f);
            }
        }
}

}  // namespace
}  // namespace penumbra
