#include "harness/exchange/export.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/image/image.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra {
namespace {

using nlohmann::json;

/// Exports small frames with a rough reference: nothing here is about its accuracy.
class Export : public ::testing::Test {
  protected:
    static constexpr int kSize = 64;
    static constexpr double kStandardError = 0.05;

    ExportOptions options(const std::string& scene, int frame) const {
        ExportOptions o;
        o.scene = scene;
        o.frame = frame;
        o.out = folder.path() / "out";
        o.truth.width = o.truth.height = kSize;
        o.truth.referenceSe = kStandardError;
        o.truth.cache = folder.path() / "cache";
        return o;
    }
    /// The exported .glb, .json, G-buffer and reference.
    std::vector<std::filesystem::path> write(const ExportOptions& o) {
        return exportFrame(o, [&](const std::string& text) { notes += text + "\n"; });
    }
    static TracedFrame traced(const std::string& scene, int frame, const TruthOptions& o) {
        return traceFrame(loadForFrame(scene, frame, o), frame, o.width, o.height);
    }

    testing::TempFolder folder;
    std::string notes;
};

/// What our own loader makes of the exported file against the frame it was made from.
void expectSameFrame(const TracedFrame& a, const TracedFrame& b, const TruthOptions& options) {
    // The loader's origin is the centre of the frame's own bounds, so that vertices are rounded to
    // float once more: by up to 2^-24 of twice the radius. The camera rays here meet their surfaces
    // at 2 degrees or more, which makes at most 3.5e-6 radii of it along the ray.
    const double tolerance = 4e-6 * a.scene->radiusM;
    EXPECT_TRUE(a.gbuffer.mask == b.gbuffer.mask) << "pixel classes differ";
    int far = 0;
    double mostNormal = 0.0, mostAlbedo = 0.0;
    for (std::size_t i = 0; i < a.gbuffer.size(); ++i) {
        if (a.gbuffer.mask[i] == PixelClass::background) continue;
        const auto world = [i](const TracedFrame& t) {
            return glm::dvec3(t.gbuffer.position[i]) + t.scene->origin;
        };
        far += glm::distance(world(a), world(b)) > tolerance;
        const auto most = [i](const auto& x, const auto& y) {
            return static_cast<double>(glm::distance(x[i], y[i]));
        };
        mostNormal =
            std::max(mostNormal, most(a.gbuffer.geometricNormal, b.gbuffer.geometricNormal));
        mostAlbedo = std::max(mostAlbedo, most(a.gbuffer.albedo, b.gbuffer.albedo));
    }
    EXPECT_EQ(far, 0) << "pixels beyond " << tolerance << " m";
    EXPECT_LT(mostNormal, 1e-3) << "vertices of triangles 1e-4 radii long, rounded as above";
    EXPECT_LT(mostAlbedo, 1e-3) << "textures are 8-bit PNG both times";

    const auto reference = [&](const TracedFrame& t) {
        return obtainReference(*t.scene, 0, *t.tracer, t.gbuffer, t.frame.light, options).reference;
    };
    const Reference ra = reference(a), rb = reference(b);
    // The same sample points: only rays that graze a silhouette within the rounding may differ.
    int differ = 0;
    float most = 0.0f;
    for (std::size_t i = 0; i < ra.visibility.size(); ++i) {
        differ += ra.visibility[i] != rb.visibility[i];
        most = std::max(most, std::abs(ra.visibility[i] - rb.visibility[i]));
    }
    EXPECT_LE(differ, static_cast<int>(ra.visibility.size()) / 100);
    EXPECT_LE(most, 0.15f) << "three times the standard error asked for";
}

TEST_F(Export, TheFileIsTheSameFrameToOurOwnLoader) {
    const auto expectRoundTrip = [&](const std::string& scene, int frame) {
        SCOPED_TRACE(scene);
        const ExportOptions o = options(scene, frame);
        const auto files = write(o);
        EXPECT_EQ(files[0].filename(), fmt::format("{}-{:04d}.glb", scene, frame));
        const TracedFrame back = traced(files[0].string(), 0, o.truth);
        EXPECT_TRUE(back.scene->chosen.empty()) << back.scene->chosen.front();
        EXPECT_EQ(back.scene->frameCount(), 1);
        expectSameFrame(traced(scene, frame, o.truth), back, o.truth);
    };
    expectRoundTrip("parallel_rectangle", 0);
    expectRoundTrip("foliage_masked", 0);
    expectRoundTrip("two_layers", 2);  // moved casters: other bounds than those of frame 0
    expectRoundTrip("fence", 1);       // a light that grows
    EXPECT_EQ(notes, "");
}

TEST_F(Export, FarFromTheOriginPrecisionIsKept) {
    testing::GltfFile file;
    const int mesh = file.quad({0.1f, 0, 0}, {0.7f, 0, 0}, {0, 0.3f, 0.1f});
    file.node({{"mesh", mesh}, {"translation", {1e6, -1e6, 1e6}}});
    const auto far = folder.write("far.glb", file.glb());
    const ExportOptions o = options(far.string(), 0);
    const auto files = write(o);
    expectSameFrame(traced(far.string(), 0, o.truth), traced(files[0].string(), 0, o.truth),
                    o.truth);
    EXPECT_NE(notes.find("light: none given"), std::string::npos) << notes;
}

TEST_F(Export, TheMatricesProjectEveryPointIntoItsOwnPixel) {
    ExportOptions o = options("fence", 2);
    o.truth.width = 96;
    const auto files = write(o);
    const json j = json::parse(test::readText(files[1]));
    const auto matrix = [](const json& rows) {
        glm::dmat4 m(0.0);
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c) m[c][r] = rows[r][c];
        return m;
    };
    const json& camera = j["camera"];
    const glm::dmat4 clip = matrix(camera["projection"]) * matrix(camera["camera_from_world"]);
    const glm::dmat4 unit =
        matrix(camera["camera_from_world"]) * matrix(camera["world_from_camera"]);
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(unit[c] - glm::dmat4(1.0)[c]), 1e-12);
    EXPECT_DOUBLE_EQ(camera["aspect"], 1.5);

    const TracedFrame frame = traced("fence", 2, o.truth);
    int surfaces = 0, outside = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * 96 + x;
            if (frame.gbuffer.mask[i] == PixelClass::background) continue;
            const glm::dvec4 p =
                clip * glm::dvec4(glm::dvec3(frame.gbuffer.position[i]) + frame.scene->origin, 1.0);
            const glm::dvec3 ndc = glm::dvec3(p) / p.w;
            // Positions are floats some metres away: 1e-6 of the image, 1e-4 pixels.
            const double offX = 48 * (ndc.x + 1) - (x + 0.5), offY = 32 * (1 - ndc.y) - (y + 0.5);
            outside += std::abs(offX) > 1e-3 || std::abs(offY) > 1e-3 || std::abs(ndc.z) > 1;
            ++surfaces;
        }
    EXPECT_GT(surfaces, 1000);
    EXPECT_EQ(outside, 0);

    const auto vec3 = [](const json& v) { return glm::dvec3(v[0], v[1], v[2]); };
    const json& light = j["light"];
    const glm::dvec3 u = vec3(light["half_axis_u"]), v = vec3(light["half_axis_v"]);
    EXPECT_NEAR(glm::distance(glm::normalize(glm::cross(u, v)), vec3(light["normal"])), 0, 1e-12);
    EXPECT_NEAR(glm::distance(vec3(light["centre"]) + u + v, vec3(light["corners"][2])), 0, 1e-12);
    EXPECT_NEAR(light["area_m2"], 4 * glm::length(u) * glm::length(v), 1e-12);
    EXPECT_EQ(j["scene"], "fence");
    EXPECT_EQ(j["frame"], 2);
    EXPECT_EQ(j["width"], 96);
    EXPECT_EQ(j["seed"], 0);
    for (const char* word :
         {"units", "axes", "matrices", "images", "light", "visibility", "casters", "scored_pixels"})
        EXPECT_FALSE(j["conventions"][word].get<std::string>().empty()) << word;
    for (const char* file : {"geometry", "gbuffer", "reference"})
        EXPECT_TRUE(std::filesystem::exists(o.out / j["files"][file].get<std::string>())) << file;
}

TEST_F(Export, TheImagesAreThoseOfARun) {
    const auto files = write(options("parallel_rectangle", 0));
    const auto channels = [](const std::filesystem::path& path) {
        std::vector<std::string> names = readImage(path).channels;
        std::ranges::sort(names);
        return names;
    };
    EXPECT_EQ(channels(files[2]),
              (std::vector<std::string>{"N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "albedo.B",
                                        "albedo.G", "albedo.R", "mask"}));
    EXPECT_EQ(channels(files[3]),
              (std::vector<std::string>{"irradiance", "irradiance_unshadowed", "rays",
                                        "standard_error", "visibility"}));
}

TEST_F(Export, APointLightIsWrittenForOthersAndSaidSo) {
    const auto script = folder.write("point.toml", R"(shows = "a test"
asset = "generated:half_plane.glb"
[camera]
position = [-1.7, 2.6, 0.0]
target = [0.15, 0.0, 0.0]
fov_y = 45.0
[light]
position = [0.0, 4.0, 0.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, -1.0]
size = [0, 0]
)");
    const auto files = write(options(script.string(), 0));
    EXPECT_NE(notes.find("KHR_lights_punctual"), std::string::npos) << notes;
    const std::string glb = test::readText(files[0]);
    EXPECT_NE(glb.find("\"KHR_lights_punctual\":{\"light\":0}"), std::string::npos);
    const json j = json::parse(test::readText(files[1]));
    EXPECT_EQ(j["light"]["kind"], "point");
    EXPECT_EQ(j["light"]["centre"], json::parse("[0.0, 4.0, 0.0]"));
}

TEST_F(Export, WhatCannotBeExportedIsSaidBeforeAnythingIsWritten) {
    const auto refusal = [&](const ExportOptions& o) -> std::string {
        try {
            write(o);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(refusal(options("fence", 3)), "--frame 3: scene 'fence' has frames 0 to 2");
    EXPECT_EQ(refusal(options("half_plane", -1)),
              "--frame -1: scene 'half_plane' has only frame 0");
    EXPECT_NE(refusal(options("nope", 0)).find("unknown scene 'nope'"), std::string::npos);
    ExportOptions masked = options("foliage_masked", 0);
    masked.truth.reference = "exact";
    EXPECT_NE(refusal(masked).find("mask"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
    folder.write("out", "a file");
    EXPECT_NE(refusal(options("half_plane", 0)).find("--out "), std::string::npos);
}

}  // namespace
}  // namespace penumbra
