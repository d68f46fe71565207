#include "harness/run/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/image/image.hpp"
#include "core/image/image_channels.hpp"
#include "harness/run/provenance.hpp"

namespace penumbra {
namespace {

constexpr std::size_t kPosition = 0, kNormal = 3, kMask = 6, kAlbedo = 7;
const std::vector<std::string> kGBufferChannels = {
    "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "mask", "albedo.R", "albedo.G", "albedo.B"};
const std::vector<std::string> kReferenceChannels = {"visibility", "standard_error", "rays",
                                                     "irradiance", "irradiance_unshadowed"};

/// A folder may have been put together by hand.
void requireSize(const std::filesystem::path& path, const ImageChannels& image, const GBuffer& g) {
    if (image.width != g.width || image.height != g.height)
        throw InputError(fmt::format("{}: {} x {} pixels, the frame's gbuffer.exr has {} x {}",
                                     path.string(), image.width, image.height, g.width, g.height));
}

}  // namespace

void writeGBuffer(const std::filesystem::path& path, const GBuffer& gbuffer,
                  const glm::dvec3& origin) {
    Image g = Image::withChannels(gbuffer.width, gbuffer.height, kGBufferChannels);
    const std::size_t stride = kGBufferChannels.size();
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        float* pixel = &g.pixels[i * stride];
        const glm::dvec3 world = glm::dvec3(gbuffer.position[i]) + origin;
        const bool surface = gbuffer.mask[i] != PixelClass::background;
        for (int c = 0; c < 3; ++c) {
            pixel[kPosition + c] = surface ? static_cast<float>(world[c]) : 0.0f;
            pixel[kNormal + c] = surface ? gbuffer.geometricNormal[i][c] : 0.0f;
            pixel[kAlbedo + c] = surface ? gbuffer.albedo[i][c] : 0.0f;
        }
        pixel[kMask] = static_cast<float>(gbuffer.mask[i]);
    }
    writeExr(path, g);
}

void writeReference(const std::filesystem::path& path, const Reference& reference) {
    Image r = Image::withChannels(reference.width, reference.height, kReferenceChannels);
    r.setChannel("visibility", reference.visibility);
    r.setChannel("standard_error", reference.standardError);
    r.setChannel("rays", reference.rays);
    r.setChannel("irradiance", reference.irradiance);
    r.setChannel("irradiance_unshadowed", reference.irradianceUnshadowed);
    writeExr(path, r);
}

std::filesystem::path RunFolder::images(const std::string& scene, int frame) const {
    return root_ / "images" / scene / fmt::format("{:04d}", frame);
}

RunFolder RunFolder::makeNew() {
    const std::filesystem::path results = resultsFolder();
    RunFolder(results).create();
    const std::string time = utcNow("%Y%m%d-%H%M%S");
    for (int number = 1;; ++number) {
        const std::filesystem::path root =
            results / (number == 1 ? time : fmt::format("{}-{}", time, number));
        if (std::filesystem::create_directory(root)) return RunFolder(root);
    }
}

void RunFolder::create() const {
    std::error_code error;
    std::filesystem::create_directories(root_, error);
    if (error) throw InputError(fmt::format("--out {}: {}", root_.string(), error.message()));
    if (access(root_.c_str(), W_OK) != 0)
        throw InputError(fmt::format("--out {}: the folder is not writable", root_.string()));
}

void RunFolder::writeTruth(const std::string& scene, int frame, const GBuffer& gbuffer,
                           const Reference& reference, const glm::dvec3& origin) const {
    const std::filesystem::path folder = images(scene, frame);
    std::filesystem::create_directories(folder);
    writeGBuffer(folder / "gbuffer.exr", gbuffer, origin);
    writeReference(folder / "reference.exr", reference);
}

void RunFolder::writeVisibility(const std::string& scene, int frame, const std::string& setting_,
                                const std::vector<float>& visibility,
                                const Reference& reference) const {
    Image image = Image::withChannels(reference.width, reference.height, {"visibility", "error"});
    for (std::size_t i = 0; i < visibility.size(); ++i) {
        image.pixels[2 * i] = visibility[i];
        image.pixels[2 * i + 1] = visibility[i] - reference.visibility[i];
    }
    writeExr(setting(scene, frame, setting_), image);
}

GBuffer RunFolder::readGBuffer(const std::string& scene, int frame) const {
    const std::filesystem::path path = images(scene, frame) / "gbuffer.exr";
    const ImageChannels image = readChannels(path, kGBufferChannels);
    GBuffer g;
    g.width = image.width;
    g.height = image.height;
    const auto vectors = [&](std::size_t first) {
        const auto &x = image.values[first], &y = image.values[first + 1],
                   &z = image.values[first + 2];
        std::vector<glm::vec3> out(x.size());
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {x[i], y[i], z[i]};
        return out;
    };
    g.position = vectors(kPosition);
    g.geometricNormal = g.shadingNormal = vectors(kNormal);
    g.albedo = vectors(kAlbedo);
    for (const float m : image.values[kMask]) {
        if (m != 0.0f && m != 1.0f && m != 2.0f && m != 3.0f)
            throw InputError(
                fmt::format("{}: a mask of {}; valid are 0, 1, 2, 3", path.string(), m));
        g.mask.push_back(static_cast<PixelClass>(m));
    }
    const std::filesystem::path reference = images(scene, frame) / "reference.exr";
    ImageChannels irradiance = readChannels(reference, {"irradiance_unshadowed"});
    requireSize(reference, irradiance, g);
    g.irradianceUnshadowed = std::move(irradiance.values.front());
    return g;
}

Reference RunFolder::readReference(const std::string& scene, int frame) const {
    const std::filesystem::path path = images(scene, frame) / "reference.exr";
    ImageChannels image = readChannels(path, kReferenceChannels);
    Reference r;
    r.width = image.width;
    r.height = image.height;
    for (std::size_t i = 0; std::vector<float> * values : {&r.visibility, &r.standardError, &r.rays,
                                                           &r.irradiance, &r.irradianceUnshadowed})
        *values = std::move(image.values[i++]);
    return r;
}

std::vector<float> RunFolder::readVisibility(const std::string& scene, int frame,
                                             const std::string& name) const {
    return std::move(readChannels(setting(scene, frame, name), {"visibility"}).values.front());
}

}  // namespace penumbra
