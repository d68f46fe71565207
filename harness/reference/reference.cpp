#include "harness/reference/reference.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <numeric>
#include <span>

#include "harness/reference/pixel_estimator.hpp"

namespace penumbra {

namespace {

constexpr int kTile = 16;
/// How far, in pixels, a neighbour that sees something else casts doubt on a constant pixel.
constexpr int kGuardRadius = 2;

/// What one surface point sees of the light, ray by ray.
class SurfaceProbe final : public LightProbe {
  public:
    SurfaceProbe(const Tracer& tracer, const AreaLight& light)
        : tracer_(tracer),
          stream_(tracer),
          corner_(light.at(0.0, 0.0)),
          edgeU_(2.0 * light.halfU * light.axisU),
          edgeV_(2.0 * light.halfV * light.axisV),
          lightNormal_(light.normal()) {}

    void moveTo(const glm::vec3& position, const glm::vec3& geometricNormal) {
        origin_ = tracer_.shadowOrigin(position, geometricNormal);
        normal_ = geometricNormal;
        fromCorner_ = corner_ - position;
    }

    void weigh(LightBatch& batch) override {
        // Copies, so that the compiler sees that writing weights changes none of them.
        const glm::vec3 corner = fromCorner_, u = edgeU_, v = edgeV_;
        const glm::vec3 normal = normal_, lightNormal = lightNormal_;
        for (std::size_t i = 0; i < batch.size; ++i) {
            const float s = batch.s[i], t = batch.t[i];
            const float x = corner.x + s * u.x + t * v.x;
            const float y = corner.y + s * u.y + t * v.y;
            const float z = corner.z + s * u.z + t * v.z;
            const float distance2 = x * x + y * y + z * z;
            const float cosP = x * normal.x + y * normal.y + z * normal.z;
            const float cosL = -(x * lightNormal.x + y * lightNormal.y + z * lightNormal.z);
            batch.weight[i] = std::max(0.0f, cosP) * std::max(0.0f, cosL) / (distance2 * distance2);
        }
    }

    void look(LightBatch& batch) override {
        stream_.clear();
        stream_.addToRectangle(origin_, corner_, edgeU_, edgeV_, batch.s.data(), batch.t.data(),
                               batch.size);
        stream_.trace();
        stream_.readVisible(batch.visible.data());
    }

  private:
    const Tracer& tracer_;
    Tracer::Stream stream_;
    glm::vec3 corner_, edgeU_, edgeV_, lightNormal_;
    glm::vec3 origin_{0.0f}, normal_{0.0f}, fromCorner_{0.0f};
};

/// The pixels to trace, tile by tile: rays of neighbouring pixels meet the same triangles.
std::vector<std::uint32_t> pixelsInTileOrder(const GBuffer& gbuffer) {
    std::vector<std::uint32_t> pixels;
    for (int tileY = 0; tileY < gbuffer.height; tileY += kTile)
        for (int tileX = 0; tileX < gbuffer.width; tileX += kTile)
            for (int y = tileY; y < std::min(tileY + kTile, gbuffer.height); ++y)
                for (int x = tileX; x < std::min(tileX + kTile, gbuffer.width); ++x) {
                    const auto i = static_cast<std::uint32_t>(y * gbuffer.width + x);
                    if (isAsked(gbuffer.mask[i])) pixels.push_back(i);
                }
    return pixels;
}

/// Reports the done fraction of a known amount of work from any thread, one call at a time.
class ProgressMeter {
  public:
    ProgressMeter(const Progress& progress, double from, double to, std::size_t total)
        : progress_(progress), from_(from), to_(to), total_(total) {}
    void advance(std::size_t amount) {
        const std::size_t done = done_ += amount;
        if (!progress_) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock)
            progress_(from_ +
                      (to_ - from_) * static_cast<double>(done) / static_cast<double>(total_));
    }

  private:
    const Progress& progress_;
    double from_, to_;
    std::size_t total_;
    std::atomic<std::size_t> done_{0};
    std::mutex mutex_;
};

/// Calls `work(probe, chunk)` for chunks of neighbours among `pixels`, in parallel. A chunk's
/// result depends on nothing but its pixels, so none depends on the number of threads.
template <class Work>
void forChunks(const std::vector<std::uint32_t>& pixels, const Tracer& tracer,
               const AreaLight& light, ProgressMeter& meter, const Work& work) {
    constexpr std::size_t kChunk = kTile * kTile;
    const std::size_t chunks = (pixels.size() + kChunk - 1) / kChunk;
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        SurfaceProbe probe(tracer, light);
        const std::size_t begin = chunk * kChunk;
        const std::size_t size = std::min(kChunk, pixels.size() - begin);
        work(probe, std::span(pixels).subspan(begin, size));
        meter.advance(size);
    });
}

/// Calls `work(probe, pixel)`, the probe at the pixel's point, for all `pixels`.
template <class Work>
void forPixels(const std::vector<std::uint32_t>& pixels, const Tracer& tracer,
               const GBuffer& gbuffer, const AreaLight& light, ProgressMeter& meter,
               const Work& work) {
    forChunks(pixels, tracer, light, meter,
              [&](SurfaceProbe& probe, std::span<const std::uint32_t> chunk) {
                  for (const std::uint32_t i : chunk) {
                      probe.moveTo(gbuffer.position[i], gbuffer.geometricNormal[i]);
                      work(probe, i);
                  }
              });
}

void set(Reference& out, std::uint32_t pixel, const PixelEstimate& estimate) {
    out.visibility[pixel] = static_cast<float>(estimate.visibility);
    out.standardError[pixel] = static_cast<float>(estimate.standardError);
    out.rays[pixel] = static_cast<float>(estimate.rays);
    out.irradiance[pixel] = static_cast<float>(estimate.shading * out.irradianceUnshadowed[pixel]);
}

void tracePoint(const std::vector<std::uint32_t>& pixels, const Tracer& tracer,
                const GBuffer& gbuffer, const AreaLight& light, const Progress& progress,
                Reference& out) {
    ProgressMeter meter(progress, 0.0, 1.0, pixels.size());
    forPixels(pixels, tracer, gbuffer, light, meter, [&](SurfaceProbe& probe, std::uint32_t i) {
        LightBatch batch;
        batch.s[0] = batch.t[0] = 0.5f;
        batch.size = 1;
        probe.look(batch);
        const double lit = batch.visible[0];
        set(out, i, {lit, 0.0, lit, 1, true});
    });
}

/// Constant pixels beside one that saw something else.
std::vector<std::uint32_t> doubtful(const std::vector<std::uint32_t>& pixels,
                                    const GBuffer& gbuffer, const Reference& out,
                                    const std::vector<std::uint8_t>& constant,
                                    const std::vector<std::uint8_t>& guarded) {
    const auto seesOther = [&](std::uint32_t i) {
        const int x0 = static_cast<int>(i) % out.width, y0 = static_cast<int>(i) / out.width;
        for (int y = std::max(0, y0 - kGuardRadius);
             y <= std::min(out.height - 1, y0 + kGuardRadius); ++y)
            for (int x = std::max(0, x0 - kGuardRadius);
                 x <= std::min(out.width - 1, x0 + kGuardRadius); ++x) {
                const std::size_t j = static_cast<std::size_t>(y) * out.width + x;
                if (isAsked(gbuffer.mask[j]) &&
                    (!constant[j] || out.visibility[j] != out.visibility[i]))
                    return true;
            }
        return false;
    };
    std::vector<std::uint8_t> doubt(pixels.size());
    tbb::parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t k) {
        const std::uint32_t i = pixels[k];
        doubt[k] = constant[i] && !guarded[i] && seesOther(i);
    });
    std::vector<std::uint32_t> found;
    for (std::size_t k = 0; k < pixels.size(); ++k)
        if (doubt[k]) found.push_back(pixels[k]);
    return found;
}

/// Tables of the default budget take 10 ms, as much as a small image's rays, and are kept. Adaptive
/// sampling reads prefixes that a larger table has too; a uniform count may end anywhere.
std::shared_ptr<const ReplicateTables> tablesFor(int points, bool adaptive) {
    constexpr int kKept = ReferenceOptions{}.maxRaysPerPixel / ReplicateTables::kReplicates;
    if (!adaptive || points > kKept) return std::make_shared<ReplicateTables>(points);
    static const auto kept = std::make_shared<const ReplicateTables>(kKept);
    return kept;
}

}  // namespace

Reference unshadowedReference(const GBuffer& gbuffer) {
    Reference out;
    out.width = gbuffer.width;
    out.height = gbuffer.height;
    out.visibility.assign(gbuffer.size(), 1.0f);
    out.standardError.assign(gbuffer.size(), 0.0f);
    out.rays.assign(gbuffer.size(), 0.0f);
    out.irradiance.assign(gbuffer.size(), 0.0f);
    out.irradianceUnshadowed = gbuffer.irradianceUnshadowed;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] == PixelClass::facingAway)
            out.visibility[i] = 0.0f;
        else if (gbuffer.mask[i] != PixelClass::background)
            out.irradiance[i] = out.irradianceUnshadowed[i];
    }
    return out;
}

double Reference::totalRays() const {
    return std::accumulate(rays.begin(), rays.end(), 0.0);
}

Reference traceReference(const Tracer& tracer, const GBuffer& gbuffer, const AreaLight& light,
                         const ReferenceOptions& options, const Progress& progress) {
    Reference out = unshadowedReference(gbuffer);
    const std::vector<std::uint32_t> pixels = pixelsInTileOrder(gbuffer);
    if (light.isPoint()) {
        tracePoint(pixels, tracer, gbuffer, light, progress, out);
        return out;
    }
    const int points = std::max(1, options.maxRaysPerPixel / ReplicateTables::kReplicates);
    const std::shared_ptr<const ReplicateTables> tables = tablesFor(points, options.adaptive);
    const PixelEstimator estimator(*tables, options.targetStandardError, options.maxRaysPerPixel);
    const auto seedOf = [&](std::uint32_t i) { return hash(i, options.seed); };

    constexpr double kMainShare = 0.9;  // of the progress; the guard's share is not known before
    ProgressMeter meter(progress, 0.0, options.adaptive ? kMainShare : 1.0, pixels.size());
    if (!options.adaptive) {
        forPixels(pixels, tracer, gbuffer, light, meter, [&](SurfaceProbe& probe, std::uint32_t i) {
            set(out, i, estimator.uniform(probe, seedOf(i)));
        });
        return out;
    }

    std::vector<std::uint32_t> place(gbuffer.size(), ~0u);  // in `pixels`
    for (std::uint32_t k = 0; k < pixels.size(); ++k) place[pixels[k]] = k;
    // Whether a neighbour in the chunk sees what this pilot missed: a twig, a gap between leaves.
    const auto doubted = [&](std::span<const std::uint32_t> chunk, const std::vector<Pilot>& pilots,
                             std::size_t k) {
        if (pilots[k].constant()) return false;
        const std::uint32_t first = place[chunk[0]];
        const int x0 = static_cast<int>(chunk[k]) % out.width;
        const int y0 = static_cast<int>(chunk[k]) / out.width;
        for (int y = std::max(0, y0 - 1); y <= std::min(out.height - 1, y0 + 1); ++y)
            for (int x = std::max(0, x0 - 1); x <= std::min(out.width - 1, x0 + 1); ++x) {
                const std::uint32_t j = place[y * out.width + x] - first;  // huge if before it
                if (j < chunk.size() && !pilots[j].constant() &&
                    pilots[k].sureOfOtherThan(pilots[j]))
                    return true;
            }
        return false;
    };
    std::vector<std::uint8_t> constant(gbuffer.size(), 0), guarded(gbuffer.size(), 0);
    forChunks(pixels, tracer, light, meter,
              [&](SurfaceProbe& probe, std::span<const std::uint32_t> chunk) {
                  std::vector<Pilot> pilots;
                  pilots.reserve(chunk.size());
                  for (const std::uint32_t i : chunk) {
                      probe.moveTo(gbuffer.position[i], gbuffer.geometricNormal[i]);
                      pilots.push_back(estimator.look(probe, seedOf(i)));
                  }
                  for (std::size_t k = 0; k < chunk.size(); ++k) {
                      const std::uint32_t i = chunk[k];
                      probe.moveTo(gbuffer.position[i], gbuffer.geometricNormal[i]);
                      if (doubted(chunk, pilots, k)) estimator.lookCloser(probe, pilots[k]);
                      const PixelEstimate estimate = estimator.finish(probe, seedOf(i), pilots[k]);
                      set(out, i, estimate);
                      constant[i] = estimate.constant;
                  }
              });

    // 256 rays that agree miss a fringe of the light of area a with a probability of exp(-256 a),
    // and where there is a penumbra next door there are fringes. Pixels found to be mixed cast
    // doubt on their own neighbours, until no more are found.
    for (;;) {
        const std::vector<std::uint32_t> doubts = doubtful(pixels, gbuffer, out, constant, guarded);
        if (doubts.empty()) break;
        ProgressMeter guardMeter(progress, kMainShare, 1.0, doubts.size());
        forPixels(doubts, tracer, gbuffer, light, guardMeter,
                  [&](SurfaceProbe& probe, std::uint32_t i) {
                      PixelEstimate pilot;
                      pilot.visibility = out.visibility[i];
                      pilot.rays = static_cast<int>(out.rays[i]);
                      const PixelEstimate estimate = estimator.guard(probe, seedOf(i), pilot);
                      set(out, i, estimate);
                      guarded[i] = 1;
                      constant[i] = estimate.constant;
                  });
    }
    if (progress) progress(1.0);
    return out;
}

std::vector<LightClass> classifyLight(const Reference& reference, const GBuffer& gbuffer) {
    std::vector<LightClass> classes(gbuffer.size(), LightClass::none);
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored) continue;
        // METHODS.md, error metrics 5: an eighth of a grey level, or what the reference can tell
        // apart.
        const double threshold =
            std::max(1.0 / 255.0, 3.0 * static_cast<double>(reference.standardError[i]));
        const double visibility = reference.visibility[i];
        classes[i] = visibility <= threshold         ? LightClass::umbra
                     : visibility >= 1.0 - threshold ? LightClass::lit
                                                     : LightClass::penumbra;
    }
    return classes;
}

}  // namespace penumbra
