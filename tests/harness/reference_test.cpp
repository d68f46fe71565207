#include "harness/reference/reference.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>

#include "core/image/image.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

const AreaLight kLight = test::lightAbove(4.0, 1.5, 1.0);

/// A plate over a floor of 32 x 32 points: lit, penumbra and umbra.
struct PlateScene {
    std::shared_ptr<const Geometry> geometry;
    GBuffer gbuffer;

    explicit PlateScene(int size = 32) {
        test::Shape shape;
        shape.rectangle({-1.0, -0.8}, {0.3, 0.5}, 1.0);
        geometry = shape.geometry();
        gbuffer = test::planeGBuffer(size, size, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, kLight);
    }
    Reference trace(const ReferenceOptions& options = {}) const {
        return traceReference(Tracer(geometry, test::kOpaque, test::kNoImages), gbuffer, kLight,
                              options);
    }
};

void expectEqual(const Reference& a, const Reference& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.visibility, b.visibility);
    EXPECT_EQ(a.standardError, b.standardError);
    EXPECT_EQ(a.rays, b.rays);
    EXPECT_EQ(a.irradiance, b.irradiance);
    EXPECT_EQ(a.irradianceUnshadowed, b.irradianceUnshadowed);
}

TEST(Reference, DoesNotDependOnTheNumberOfThreads) {
    const PlateScene scene;
    const Reference parallel = scene.trace();
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    expectEqual(scene.trace(), parallel);
}

TEST(Reference, SeedsGiveOtherSamplesOfTheSameTruth) {
    const PlateScene scene;
    ReferenceOptions options;
    const Reference a = scene.trace(options);
    options.seed = 1;
    const Reference b = scene.trace(options);
    EXPECT_NE(a.visibility, b.visibility);
    for (std::size_t i = 0; i < a.visibility.size(); ++i)
        EXPECT_NEAR(a.visibility[i], b.visibility[i], 1e-2) << i;
}

TEST(Reference, UnoccludedPointsAreExactlyLit) {
    test::Shape shape;
    shape.rectangle({-2, -2}, {2, 2}, 0.0);  // the receiver itself
    const GBuffer gbuffer = test::planeGBuffer(16, 16, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, kLight);
    const Reference reference = traceReference(
        Tracer(shape.geometry(), test::kOpaque, test::kNoImages), gbuffer, kLight, {});
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        EXPECT_EQ(reference.visibility[i], 1.0f);
        EXPECT_EQ(reference.standardError[i], 3.0f / 256.0f);
        EXPECT_EQ(reference.rays[i], 256.0f);
        EXPECT_EQ(reference.irradiance[i], gbuffer.irradianceUnshadowed[i]);
    }
    EXPECT_EQ(reference.totalRays(), 256.0 * 256.0);
}

TEST(Reference, UmbraIsExactlyDark) {
    const PlateScene scene;
    const Reference reference = scene.trace();
    int umbra = 0;
    for (std::size_t i = 0; i < scene.gbuffer.size(); ++i) {
        const glm::vec3 p = scene.gbuffer.position[i];
        // Well inside the plate's umbra: its edges move by less than half a metre.
        if (p.x < -0.6f || p.x > -0.2f || p.y < -0.3f || p.y > 0.0f) continue;
        ++umbra;
        EXPECT_EQ(reference.visibility[i], 0.0f);
        EXPECT_EQ(reference.irradiance[i], 0.0f);
    }
    EXPECT_GT(umbra, 4);
}

TEST(Reference, PixelsWithoutLightCostNothing) {
    PlateScene scene(4);
    scene.gbuffer.mask[0] = PixelClass::background;
    scene.gbuffer.mask[1] = PixelClass::facingAway;
    const Reference reference = scene.trace();
    EXPECT_EQ(reference.visibility[0], 1.0f);
    EXPECT_EQ(reference.visibility[1], 0.0f);
    for (const int i : {0, 1}) {
        EXPECT_EQ(reference.rays[i], 0.0f);
        EXPECT_EQ(reference.standardError[i], 0.0f);
    }
}

TEST(Reference, HorizonPixelsAnswerForTheWholeLight) {
    // A wall under the light's middle: half of the light is behind it, and it is geometry like any
    // other. Nothing hides the half before it, which gives all of the irradiance.
    test::Shape wall;
    wall.quad({0, -1, 0}, {0, 1, 0}, {0, 1, 1}, {0, -1, 1});
    GBuffer gbuffer = test::planeGBuffer(4, 4, {0, -1, 0}, {0, 2, 0}, {0, 0, 1}, kLight);
    EXPECT_EQ(gbuffer.count(PixelClass::horizon), 16u);
    const Reference reference = traceReference(
        Tracer(wall.geometry(), test::kOpaque, test::kNoImages), gbuffer, kLight, {});
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        EXPECT_NEAR(reference.visibility[i], 0.5f, 5e-3f);
        EXPECT_NEAR(reference.irradiance[i], gbuffer.irradianceUnshadowed[i],
                    0.01f * gbuffer.irradianceUnshadowed[i]);
    }
}

TEST(Reference, PointLightIsOneRay) {
    const PlateScene scene;
    AreaLight point = kLight;
    point.halfU = point.halfV = 0.0;
    const GBuffer gbuffer = test::planeGBuffer(32, 32, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, point);
    const Reference reference =
        traceReference(Tracer(scene.geometry, test::kOpaque, test::kNoImages), gbuffer, point, {});
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        // The plate's shadow from (0, 0, 4): magnified by 4/3.
        const glm::vec3 p = gbuffer.position[i] * 0.75f;
        const bool dark = p.x > -1.0f && p.x < 0.3f && p.y > -0.8f && p.y < 0.5f;
        EXPECT_EQ(reference.visibility[i], dark ? 0.0f : 1.0f);
        EXPECT_EQ(reference.standardError[i], 0.0f);
        EXPECT_EQ(reference.rays[i], 1.0f);
        EXPECT_EQ(reference.irradiance[i], dark ? 0.0f : gbuffer.irradianceUnshadowed[i]);
    }
}

TEST(Reference, CoupledIrradianceIsTheIntegralOverTheVisiblePart) {
    // A large light close by, where shading and visibility are far from independent.
    const AreaLight light = test::lightAbove(0.5, 2.0, 2.0);
    test::Shape shape;
    shape.rectangle({0, -20}, {20, 20}, 0.25);
    const GBuffer gbuffer = test::planeGBuffer(12, 2, {-1, -0.1, 0}, {2, 0, 0}, {0, 0.2, 0}, light);
    const Reference reference = traceReference(
        Tracer(shape.geometry(), test::kOpaque, test::kNoImages), gbuffer, light, {});
    double separated = 0.0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        // The half-plane x > 0 at half the height hides the light's part x > -p.x.
        const double x = gbuffer.position[i].x, edge = std::clamp(-x, -1.0, 1.0);
        AreaLight visible = light;
        visible.centre.x = 0.5 * (edge - 1.0);
        visible.halfU = 0.5 * (edge + 1.0);
        const double expected =
            unshadowedIrradiance(glm::dvec3(gbuffer.position[i]), {0, 0, 1}, visible);
        const double full = gbuffer.irradianceUnshadowed[i];
        // The weight varies by a factor of 20 over this light: a few times the error of V.
        EXPECT_NEAR(reference.irradiance[i], expected, 8e-3 * full) << x;
        separated = std::max(separated, std::abs(reference.visibility[i] * full - expected) / full);
    }
    EXPECT_GT(separated, 0.05) << "the scene would not tell the two apart";
}

TEST(Reference, UniformSamplingSpendsTheSameEverywhere) {
    const PlateScene scene(8);
    ReferenceOptions options;
    options.adaptive = false;
    options.maxRaysPerPixel = 1024;
    const Reference reference = scene.trace(options);
    for (const float rays : reference.rays) EXPECT_EQ(rays, 1024.0f);
}

TEST(Reference, PixelsBesideAPenumbraAreGuarded) {
    const PlateScene scene;
    const Reference reference = scene.trace();
    int guarded = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 1; x < 32; ++x) {
            const int i = y * 32 + x;
            const auto constant = [&](int j) {
                return reference.visibility[j] == 0.0f || reference.visibility[j] == 1.0f;
            };
            if (!constant(i) || reference.visibility[i] == reference.visibility[i - 1]) continue;
            ++guarded;
            EXPECT_GE(reference.rays[i], 1280.0f);
        }
    EXPECT_GT(guarded, 5);
}

TEST(Reference, ProgressEndsAtOne) {
    const PlateScene scene;
    double last = 0.0;
    traceReference(Tracer(scene.geometry, test::kOpaque, test::kNoImages), scene.gbuffer, kLight,
                   {}, [&](double fraction) {
                       EXPECT_GE(fraction, 0.0);
                       EXPECT_LE(fraction, 1.0);
                       last = fraction;
                   });
    EXPECT_EQ(last, 1.0);
}

TEST(LightClasses, ThresholdsFollowTheError) {
    Reference reference;
    GBuffer gbuffer;
    const struct {
        float visibility, error;
        PixelClass mask;
        LightClass expected;
    } cases[] = {
        {1.0f, 0.0f, PixelClass::scored, LightClass::lit},
        {0.0f, 0.0f, PixelClass::scored, LightClass::umbra},
        {0.5f, 0.001f, PixelClass::scored, LightClass::penumbra},
        {0.003f, 0.001f, PixelClass::scored, LightClass::umbra},     // below 1/255
        {0.005f, 0.001f, PixelClass::scored, LightClass::penumbra},  // above it
        {0.02f, 0.01f, PixelClass::scored, LightClass::umbra},       // below 3 errors
        {0.98f, 0.01f, PixelClass::scored, LightClass::lit},
        {0.5f, 0.001f, PixelClass::horizon, LightClass::none},
        {1.0f, 0.0f, PixelClass::background, LightClass::none},
        {0.0f, 0.0f, PixelClass::facingAway, LightClass::none},
    };
    for (const auto& c : cases) {
        reference.visibility.push_back(c.visibility);
        reference.standardError.push_back(c.error);
        gbuffer.mask.push_back(c.mask);
    }
    const std::vector<LightClass> classes = classifyLight(reference, gbuffer);
    for (std::size_t i = 0; i < std::size(cases); ++i)
        EXPECT_EQ(classes[i], cases[i].expected) << i;
}

class Cache : public testing::Test {
  protected:
    Cache() {
        folder_ = std::filesystem::path(testing::TempDir()) /
                  (std::string("penumbra_cache_") +
                   testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder_);
    }
    ~Cache() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path folder_;
};

TEST_F(Cache, RoundTripIsBitExact) {
    const PlateScene scene;
    const Reference reference = scene.trace();
    const ReferenceCache cache(folder_ / "deep" / "er");
    EXPECT_FALSE(cache.load("key", 32, 32));
    cache.store("key", reference);
    const std::optional<Reference> loaded = cache.load("key", 32, 32);
    ASSERT_TRUE(loaded);
    expectEqual(*loaded, reference);
    EXPECT_FALSE(cache.load("key", 32, 31)) << "another size";
    EXPECT_FALSE(cache.load("other", 32, 32));
}

TEST_F(Cache, TornOrForeignEntriesAreAbsent) {
    const PlateScene scene;
    const ReferenceCache cache(folder_);
    cache.store("key", scene.trace());
    const std::filesystem::path entry = folder_ / "key.exr";
    const auto whole = std::filesystem::file_size(entry);
    for (const auto size : {whole - 7, whole / 2, std::uintmax_t{20}, std::uintmax_t{0}}) {
        std::filesystem::resize_file(entry, size);
        EXPECT_FALSE(cache.load("key", 32, 32)) << "cut to " << size << " of " << whole;
    }
    std::ofstream(entry) << "not an image at all";
    EXPECT_FALSE(cache.load("key", 32, 32));
    writeExr(entry, Image::withChannels(32, 32, {"visibility", "rays"}));
    EXPECT_FALSE(cache.load("key", 32, 32)) << "other channels";
    std::filesystem::remove(entry);
    std::filesystem::create_directory(entry);
    EXPECT_FALSE(cache.load("key", 32, 32)) << "a folder";
}

TEST_F(Cache, UnwritableFolderIsAnException) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "file") << "in the way";
    const ReferenceCache cache(folder_ / "file" / "cache");
    EXPECT_THROW(cache.store("key", PlateScene(4).trace()), std::runtime_error);
    EXPECT_FALSE(cache.load("key", 4, 4));
}

TEST_F(Cache, KeyCoversAllThatTheReferenceReads) {
    const PlateScene scene(4);
    Geometry geometry = *scene.geometry;
    std::vector<Material> materials(1);
    materials[0].masked = true;
    materials[0].baseColorTexture = 0;
    std::vector<TextureImage> images(1);
    images[0].width = images[0].height = 1;
    images[0].rgba = {1, 2, 3, 4};
    GBuffer gbuffer = scene.gbuffer;
    AreaLight light = kLight;
    ReferenceOptions options;
    const auto key = [&] {
        return ReferenceCache::key(geometry, materials, images, gbuffer, light, options);
    };
    const std::string original = key();
    EXPECT_EQ(original.size(), 32u);
    EXPECT_EQ(original.find_first_not_of("0123456789abcdef"), std::string::npos);

    // Changes one thing, expects another key, changes it back and expects the original.
    const auto matters = [&](auto& value, auto changed, const char* what) {
        const auto before = value;
        value = changed;
        EXPECT_NE(key(), original) << what;
        value = before;
        EXPECT_EQ(key(), original) << what;
    };
    matters(geometry.positions[0].x, 0.123f, "a vertex");
    matters(geometry.indices[0], 2u, "an index");
    matters(geometry.uvs[0].y, 0.5f, "texture coordinates of a masked material");
    matters(geometry.parts[0].indexCount, 3u, "a part");
    matters(materials[0].masked, false, "masked");
    matters(materials[0].alphaCutoff, 0.25f, "cutoff");
    matters(materials[0].baseColor.a, 0.5f, "base alpha");
    matters(materials[0].baseColorTexture, -1, "texture");
    matters(images[0].rgba[3], std::uint8_t{5}, "a texel");
    matters(images[0].linear, false, "filter");
    matters(images[0].wrapS, Wrap::clampToEdge, "wrap");
    matters(gbuffer.position[3].z, 0.1f, "a point");
    matters(gbuffer.geometricNormal[3], glm::vec3(0, 1, 0), "a normal");
    matters(gbuffer.mask[3], PixelClass::background, "a class");
    matters(gbuffer.irradianceUnshadowed[3], 0.5f, "irradiance");
    matters(light.centre.x, 0.25, "light position");
    matters(light.axisU.x, 0.5, "light axis");
    matters(light.halfV, 0.25, "light size");
    matters(options.targetStandardError, 0.01, "target");
    matters(options.seed, 7u, "seed");
    matters(options.adaptive, false, "adaptive");
    matters(options.maxRaysPerPixel, 512, "budget");

    // What it does not read does not matter: colours, names, texture coordinates where none are
    // used.
    materials[0].name = "renamed";
    materials[0].baseColor.r = 0.1f;
    gbuffer.albedo[0] = glm::vec3(0.9f);
    EXPECT_EQ(key(), original);
}

TEST(CacheFolder, FollowsTheXdgSpecification) {
    const char* cacheBefore = std::getenv("XDG_CACHE_HOME");
    const char* homeBefore = std::getenv("HOME");
    const std::string cacheValue = cacheBefore ? cacheBefore : "",
                      homeValue = homeBefore ? homeBefore : "";
    setenv("HOME", "/some/home", 1);
    setenv("XDG_CACHE_HOME", "/some/cache", 1);
    EXPECT_EQ(ReferenceCache::defaultFolder(), "/some/cache/penumbra");
    setenv("XDG_CACHE_HOME", "relative", 1);
    EXPECT_EQ(ReferenceCache::defaultFolder(), "/some/home/.cache/penumbra");
    unsetenv("XDG_CACHE_HOME");
    EXPECT_EQ(ReferenceCache::defaultFolder(), "/some/home/.cache/penumbra");
    if (cacheBefore) setenv("XDG_CACHE_HOME", cacheValue.c_str(), 1);
    if (homeBefore) setenv("HOME", homeValue.c_str(), 1);
}

}  // namespace
}  // namespace penumbra
