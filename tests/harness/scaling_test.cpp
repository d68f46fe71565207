#include "harness/study/scaling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "harness/study/study_frame.hpp"
#include "harness/study/varied_scene.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

constexpr std::array<double, 4> kX = {1.0, 4.0, 16.0, 64.0};

std::vector<double> powers(double c, double exponent) {
    std::vector<double> y;
    for (const double x : kX) y.push_back(c * std::pow(x, exponent));
    return y;
}

TEST(PowerLaw, IsFoundExactly) {
    for (const double exponent : {-0.5, 0.0, 1.0, 2.25}) {
        const PowerLaw law = fitPowerLaw(kX, powers(3.0, exponent));
        EXPECT_NEAR(law.exponent, exponent, 1e-12);  // rounding of logarithms
        EXPECT_NEAR(law.worstFactor, 1.0, 1e-12);
    }
}

TEST(PowerLaw, SaysHowFarThePointsLieOff) {
    // A constant cost beside a linear one: 1 + x. By hand: exponent 0.8417, and of the four points
    // the second lies farthest off, exp(1.7442 - ln 5) = 1.144.
    const std::vector<double> y = {2.0, 5.0, 17.0, 65.0};
    const PowerLaw law = fitPowerLaw(kX, y);
    EXPECT_NEAR(law.exponent,
                (1.5 * std::log(65.0 / 2.0) + 0.5 * std::log(17.0 / 5.0)) / (5.0 * std::log(4.0)),
                1e-12);
    EXPECT_NEAR(law.worstFactor, 1.144, 5e-4);  // the digits given
}

TEST(PowerLaw, RefusesWhatHasNoLogarithm) {
    const std::vector<double> one = {1.0}, same = {2.0, 2.0}, zero = {0.0, 1.0}, two = {1.0, 2.0};
    EXPECT_THROW(fitPowerLaw(one, one), std::invalid_argument);
    EXPECT_THROW(fitPowerLaw(same, two), std::invalid_argument);
    EXPECT_THROW(fitPowerLaw(two, zero), std::invalid_argument);
    EXPECT_THROW(fitPowerLaw(two, one), std::invalid_argument);
}

/// A machine that slows down from round to round slows all of a round alike.
TEST(Growth, IsUntouchedByDriftBetweenRounds) {
    std::vector<std::vector<double>> rounds;
    for (const double drift : {1.0, 1.7, 0.9, 3.0, 2.0}) rounds.push_back(powers(drift, 0.75));
    const auto growth = growthOf(kX, rounds, 1);
    ASSERT_TRUE(growth);
    EXPECT_NEAR(growth->exponent.median, 0.75, 1e-12);
    EXPECT_NEAR(growth->exponent.low, 0.75, 1e-12);
    EXPECT_NEAR(growth->exponent.high, 0.75, 1e-12);
    EXPECT_NEAR(growth->worstFactor, 1.0, 1e-12);
}

TEST(Growth, HasTheIntervalOfItsRounds) {
    const auto growth =
        growthOf(kX, {powers(1, 0.9), powers(1, 1.0), powers(1, 1.0), powers(1, 1.2)}, 1);
    ASSERT_TRUE(growth);
    EXPECT_NEAR(growth->exponent.median, 1.0, 1e-12);
    EXPECT_GE(growth->exponent.low, 0.9 - 1e-12);
    EXPECT_LT(growth->exponent.low, 1.0);
    EXPECT_GT(growth->exponent.high, 1.0);
    EXPECT_LE(growth->exponent.high, 1.2 + 1e-12);
}

TEST(Growth, IsAbsentWithoutTimesOrPoints) {
    EXPECT_FALSE(growthOf(kX, {{0.0, 0.0, 0.0, 0.0}}, 1));
    EXPECT_FALSE(growthOf(kX, {}, 1));
    EXPECT_FALSE(growthOf(std::span(kX).first(1), {{1.0}}, 1));
}

TEST(ScalingAxis, IsNamed) {
    for (const char* name : {"triangles", "pixels", "map_size", "light_size", "slices"})
        EXPECT_STREQ(nameOf(parseScalingAxis(name)), name);
    EXPECT_THROW(parseScalingAxis("threads"), InputError);
}

double areaM2(const Geometry& g) {
    double area = 0.0;
    for (std::size_t t = 0; t < g.indices.size(); t += 3) {
        const auto at = [&](std::size_t i) { return glm::dvec3(g.positions[g.indices[t + i]]); };
        area += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    return area;
}

/// Edges, by their ends' very floats, that an odd number of triangles has: the rims of the surface.
std::size_t rimEdges(const Geometry& g) {
    using Point = std::array<float, 3>;
    std::map<std::pair<Point, Point>, int> count;
    for (std::size_t t = 0; t < g.indices.size(); t += 3)
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3 a = g.positions[g.indices[t + i]],
                            b = g.positions[g.indices[t + (i + 1) % 3]];
            Point p{a.x, a.y, a.z}, q{b.x, b.y, b.z};
            if (q < p) std::swap(p, q);
            ++count[{p, q}];
        }
    return static_cast<std::size_t>(
        std::ranges::count_if(count, [](const auto& entry) { return entry.second % 2; }));
}

TEST(Subdivision, KeepsTheSurface) {
    const auto scene = loadScene("gathering", SceneLibrary::standard());
    const auto coarse = scene->frame(0).geometry;
    const auto fine = subdivided(coarse, 2);
    EXPECT_EQ(fine->triangleCount(), 16 * coarse->triangleCount());
    // Middles are rounded by half an ulp (6e-8) of some metres; triangles are 0.01 m and more.
    EXPECT_NEAR(areaM2(*fine) / areaM2(*coarse), 1.0, 1e-5);
    // A closed surface stays closed; a rim of n edges has 4n.
    EXPECT_EQ(rimEdges(*fine), 4 * rimEdges(*coarse));
    std::uint32_t vertex = 0, index = 0;
    ASSERT_EQ(fine->parts.size(), coarse->parts.size());
    for (std::size_t i = 0; i < fine->parts.size(); ++i) {
        const Part& part = fine->parts[i];
        EXPECT_EQ(part.firstVertex, vertex);
        EXPECT_EQ(part.firstIndex, index);
        EXPECT_EQ(part.indexCount, 16 * coarse->parts[i].indexCount);
        EXPECT_EQ(part.name, coarse->parts[i].name);
        for (std::uint32_t k = 0; k < part.indexCount; ++k)
            ASSERT_LT(fine->indices[index + k] - vertex, part.vertexCount);
        vertex += part.vertexCount;
        index += part.indexCount;
    }
    EXPECT_EQ(vertex, fine->positions.size());
    EXPECT_EQ(vertex, fine->normals.size());
    EXPECT_EQ(vertex, fine->uvs.size());
    EXPECT_EQ(index, fine->indices.size());
    for (const glm::vec3& n : fine->normals) ASSERT_NEAR(glm::length(n), 1.0F, 1e-5F);
}

TEST(Subdivision, HasAnEnd) {
    const auto scene = loadScene("half_plane", SceneLibrary::standard());
    EXPECT_THROW(subdivided(scene->frame(0).geometry, 20), InputError);
}

TEST(VariedScene, ChangesWhatItSaysAndNothingElse) {
    const auto scene = loadScene("fence", SceneLibrary::standard());
    EXPECT_EQ(varied(scene, {}), scene);
    const auto wide = varied(scene, {2.0, 1});
    EXPECT_EQ(wide->id, scene->id);
    EXPECT_EQ(wide->frameCount(), scene->frameCount());
    for (int i = 0; i < scene->frameCount(); ++i) {
        AreaLight light = scene->frame(i).light;
        light.halfU *= 2.0, light.halfV *= 2.0;
        EXPECT_EQ(wide->frame(i).light, light);
        EXPECT_EQ(wide->frame(i).camera, scene->frame(i).camera);
    }
    EXPECT_EQ(wide->frame(0).geometry, wide->frame(1).geometry) << "nothing moves";
}

class SubdividedImage : public test::GlTest {};

TEST_F(SubdividedImage, IsTheSame) {
    const auto scene = loadScene("gathering", SceneLibrary::standard());
    SettingChoice choice;
    choice.methods = {"light_sampled"};
    const Setting setting = expandSettings(choice).front();
    std::vector<std::vector<float>> images;
    for (const int times : {0, 2}) {
        const StudyFrame staged(varied(scene, {.subdivisions = times}), 0, 96, 96, 0);
        SettingRun run(setting);
        EXPECT_EQ(staged.warmUp(run).maps, 16.0);
        images.push_back(run.visibility());
    }
    std::size_t pixels = images[0].size(), differing = 0;
    for (std::size_t i = 0; i < pixels; ++i) differing += images[0][i] != images[1][i];
    // Half an ulp of a middle moves a map texel at an outline now and then: 16 maps, a penumbra
    // pixel each changes by a sixteenth. One pixel in fifty is far above that and far below what a
    // hole or a lost triangle would change.
    EXPECT_LT(differing, pixels / 50);
    for (std::size_t i = 0; i < pixels; ++i) ASSERT_NEAR(images[0][i], images[1][i], 0.2F);
}

}  // namespace
}  // namespace penumbra
