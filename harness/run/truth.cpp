#include "harness/run/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/error.hpp"
#include "harness/reference/exact.hpp"

namespace penumbra {
namespace {

Reference cachedReference(const Scene& scene, const Tracer& tracer, const GBuffer& gbuffer,
                          const AreaLight& light, const ReferenceOptions& options,
                          const std::filesystem::path& folder, const Progress& progress,
                          ObtainedReference& out) {
    const ReferenceCache cache(folder.empty() ? ReferenceCache::defaultFolder() : folder);
    const std::string key = ReferenceCache::key(tracer.geometry(), scene.materials, scene.images,
                                                gbuffer, light, options);
    std::string damage;
    std::optional<Reference> stored = cache.load(key, gbuffer.width, gbuffer.height, &damage);
    if (!damage.empty())
        out.notes.push_back(fmt::format("the cached reference is traced again: {}", damage));
    out.stats.cached = stored.has_value();
    if (stored) return *std::move(stored);
    Reference reference = traceReference(tracer, gbuffer, light, options, progress);
    try {
        cache.store(key, reference);
    } catch (const std::exception& e) {
        out.notes.push_back(fmt::format("the reference is not cached: {}", e.what()));
    }
    return reference;
}

Reference exactReferenceOf(const Scene& scene, const Tracer& tracer, const GBuffer& gbuffer,
                           const AreaLight& light, const ReferenceOptions& options,
                           const Progress& progress, ObtainedReference& out) {
    ExactOptions exact;
    exact.fallback = options;
    ExactStats counts;
    Reference reference =
        exactReference(tracer, scene.materials, gbuffer, light, exact, progress, &counts);
    if (counts.tracedPixels > 0)
        out.notes.push_back(
            fmt::format("{} frame {}: {} pixels of the reference are traced, not "
                        "exact",
                        scene.id, out.stats.frame, counts.tracedPixels));
    return reference;
}

}  // namespace

int TruthOptions::threadCount() const {
    return threads > 0 ? threads
                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

ObtainedReference obtainReference(const Scene& scene, int index, const Tracer& tracer,
                                  const GBuffer& gbuffer, const AreaLight& light,
                                  const TruthOptions& options, const Progress& progress) {
    ReferenceOptions tracing;
    tracing.targetStandardError = options.referenceSe;
    tracing.seed = options.seed;
    ObtainedReference out;
    ReferenceStats& stats = out.stats;
    stats.scene = scene.id;
    stats.frame = index;
    const auto start = std::chrono::steady_clock::now();
    out.reference =
        options.reference == "exact"
            ? exactReferenceOf(scene, tracer, gbuffer, light, tracing, progress, out)
            : cachedReference(scene, tracer, gbuffer, light, tracing, options.cache, progress, out);
    stats.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    stats.rays = out.reference.totalRays();
    for (LightClass c : classifyLight(out.reference, gbuffer))
        stats.penumbraPixels += c == LightClass::penumbra;
    stats.scoredPixels = gbuffer.count(PixelClass::scored);
    float most = 0.0f;
    std::size_t traced = 0;
    for (float rays : out.reference.rays) most = std::max(most, rays), traced += rays > 0.0f;
    stats.uniformEquivalentRays = static_cast<double>(most) * static_cast<double>(traced);
    return out;
}

std::shared_ptr<const Scene> loadForFrame(const std::string& name, int index,
                                          const TruthOptions& options) {
    std::shared_ptr<const Scene> scene;
    try {
        scene = loadScene(name, SceneLibrary::standard(), options.load);
    } catch (const AssetAbsent& e) {
        throw InputError(e.what());
    }
    const int last = scene->frameCount() - 1;
    if (index < 0 || index > last)
        throw InputError(
            fmt::format("--frame {}: scene '{}' has {}", index, scene->id,
                        last == 0 ? "only frame 0" : fmt::format("frames 0 to {}", last)));
    if (options.reference == "exact") refuseMasked(*scene->frame(index).geometry, scene->materials);
    return scene;
}

TracedFrame traceFrame(std::shared_ptr<const Scene> scene, int index, int width, int height) {
    TracedFrame out{std::move(scene), index, {}, nullptr, {}};
    out.frame = out.scene->frame(index);
    out.tracer =
        std::make_unique<Tracer>(out.frame.geometry, out.scene->materials, out.scene->images);
    out.gbuffer = renderGBuffer(*out.tracer, out.frame, *out.scene, width, height);
    return out;
}

}  // namespace penumbra
