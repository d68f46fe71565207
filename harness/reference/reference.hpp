#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// Ray-traced truth at a G-buffer's points. Row-major, top row first, one entry per pixel.
/// Background pixels hold visibility 1, facing-away pixels 0, both with no rays and no error.
struct Reference {
    int width = 0, height = 0;
    std::vector<float> visibility;            ///< V in [0,1], over the whole light
    std::vector<float> standardError;         ///< of visibility, or the zero-count bound 3/n (see below)
    std::vector<float> rays;                  ///< spent on the pixel
    std::vector<float> irradiance;            ///< coupled: visibility inside the light integral, unit radiance
    std::vector<float> irradianceUnshadowed;  ///< analytic

    double totalRays() const;
};

/// What the reference says where nothing is in the light's way.
Reference unshadowedReference(const GBuffer& gbuffer);

/// How the reference is traced. Sampling: R independent Owen-scrambled Sobol replicates of n points
/// each; the standard error is the spread of their means over sqrt(R), never the binomial formula.
struct ReferenceOptions {
    double targetStandardError = 1.0 / 1024;
    std::uint32_t seed = 0;
    bool adaptive = true;  ///< false: every pixel gets `maxRaysPerPixel` (for comparisons only)
    int maxRaysPerPixel = 65536;
};

/// Called now and then with the fraction done in [0,1]. What it throws ends the work it tells about
/// and reaches the caller.
using Progress = std::function<void(double)>;

Reference traceReference(const Tracer& tracer, const GBuffer& gbuffer, const AreaLight& light,
                         const ReferenceOptions& options, const Progress& progress = {});

/// What of a pixel the reference says: thresholds at max(1/255, 3 standard errors) from 0 and 1.
enum class LightClass : std::uint8_t { none, lit, penumbra, umbra };
std::vector<LightClass> classifyLight(const Reference& reference, const GBuffer& gbuffer);

/// References on disk by content: the key covers everything traceReference reads (points, normals,
/// classes, triangles, alpha textures, light, options, algorithm version), so an entry is never
/// stale. Safe against other processes and against a kill: entries are complete or absent, and each
/// carries a hash of its bytes, so that what a disk or a user did to it is noticed. What a kill left
/// half-written goes when something is stored an hour later.
class ReferenceCache {
  public:
    explicit ReferenceCache(std::filesystem::path folder);
    /// $XDG_CACHE_HOME/penumbra, else ~/.cache/penumbra.
    static std::filesystem::path defaultFolder();
    static std::string key(const Geometry& geometry, const std::vector<Material>& materials,
                           const std::vector<TextureImage>& images, const GBuffer& gbuffer,
                           const AreaLight& light, const ReferenceOptions& options);
    /// Absent, unreadable, damaged or of the wrong size: nullopt; `damage` is told of an entry that is
    /// there, with its file and what is wrong.
    std::optional<Reference> load(const std::string& key, int width, int height,
                                  std::string* damage = nullptr) const;
    /// Throws std::runtime_error with the reason.
    void store(const std::string& key, const Reference& reference) const;

  private:
    std::filesystem::path entry(const std::string& key) const;

    std::filesystem::path folder_;
};

}  // namespace penumbra
