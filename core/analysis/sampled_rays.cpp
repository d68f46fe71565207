#include "core/analysis/sampled_rays.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "core/sampling/sampling.hpp"

namespace penumbra {
namespace {

/// Every so many rays one is followed: that costs more than all of the others together.
constexpr std::size_t kFollowedStride = 4;
constexpr int kMostHits = 16;
constexpr std::uint32_t kSeed = 0xeffec75u;
/// Of a ray's length: what lies closer together is met at the edge between two triangles.
constexpr double kOnePlace = 1e-5;

using MaybePart = std::optional<std::size_t>;

struct Followed {
    bool layered = false;
    std::vector<std::size_t> parts;  ///< that it met
    MaybePart start;                 ///< the part that it starts on
};

/// Which part has its surface at the point.
MaybePart partAt(const Tracer& tracer, const Receivers::Sample& point) {
    const glm::dvec3 position(point.position), normal(point.normal);
    const glm::dvec3 outside(tracer.shadowOrigin(point.position, point.normal));
    // shadowOrigin moves by the rounding of positions; some of that on both sides.
    const double reachM = 4.0 * glm::length(outside - position);
    const SurfaceHit hit = tracer.firstHit(position + reachM * normal, -normal, 0.0, 2.0 * reachM);
    if (!hit.hit) return std::nullopt;
    return tracer.geometry().partOf(hit.triangle);
}

/// Goes from the light to the point, through everything.
Followed follow(const Tracer& tracer, const Casters& bodies, const Receivers::Sample& point,
                const glm::dvec3& onLight) {
    struct Met {
        std::uint32_t body;
        int crossings;
        double lastT;
    };
    Followed result;
    result.start = partAt(tracer, point);
    const Geometry& geometry = tracer.geometry();
    const glm::dvec3 direction =
        glm::dvec3(tracer.shadowOrigin(point.position, point.normal)) - onLight;
    std::vector<Met> met;
    double t = 1e-4;  // as Tracer::Stream: what lies in the light's plane does not block
    for (int k = 0; k < kMostHits; ++k) {
        const SurfaceHit hit = tracer.firstHit(onLight, direction, t, 1.0);
        if (!hit.hit) break;
        const double at =
            glm::dot(hit.position - onLight, direction) / glm::dot(direction, direction);
        t = std::max(t, at) + 1e-6;
        result.parts.push_back(geometry.partOf(hit.triangle));
        const std::uint32_t body = bodies.ofVertex[geometry.indices[3 * hit.triangle]];
        const auto known = std::ranges::find(met, body, &Met::body);
        if (known == met.end())
            met.push_back({body, 1, at});
        else if (at - known->lastT > kOnePlace)
            ++known->crossings, known->lastT = at;
    }
    // A solid is entered and left: two crossings are one caster.
    result.layered =
        met.size() > 1 || std::ranges::any_of(met, [](const Met& m) { return m.crossings > 2; });
    return result;
}

}  // namespace

SampledRays SampledRays::trace(const Tracer& tracer, const Receivers& receivers,
                               const Casters& bodies) {
    const std::vector<Receivers::Sample> samples = receivers.samples();
    std::vector<glm::dvec3> onLight(samples.size());
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
        const auto unit = [&](std::uint32_t axis) { return toUnitFloat(hash(kSeed, i, axis)); };
        onLight[i] = receivers.light().at(unit(0), unit(1));
    }
    std::vector<std::uint8_t> visible(samples.size());
    std::vector<Followed> followed((samples.size() + kFollowedStride - 1) / kFollowedStride);
    const std::size_t streams = (samples.size() + Tracer::kStreamSize - 1) / Tracer::kStreamSize;
    tbb::parallel_for(std::size_t{0}, streams, [&](std::size_t s) {
        const std::size_t begin = s * Tracer::kStreamSize;
        const std::size_t end = std::min(begin + Tracer::kStreamSize, samples.size());
        Tracer::Stream stream(tracer);
        for (std::size_t i = begin; i < end; ++i)
            stream.add(tracer.shadowOrigin(samples[i].position, samples[i].normal),
                       glm::vec3(onLight[i]));
        stream.trace();
        stream.readVisible(&visible[begin]);
        static_assert(Tracer::kStreamSize % kFollowedStride == 0);
        for (std::size_t i = begin; i < end; i += kFollowedStride)
            followed[i / kFollowedStride] = follow(tracer, bodies, samples[i], onLight[i]);
    });

    SampledRays out;
    out.rays = samples.size();
    out.followed = followed.size();
    out.blocked = static_cast<std::size_t>(std::ranges::count(visible, 0));
    out.blocks.resize(tracer.geometry().parts.size(), 0);
    for (const Followed& f : followed) {
        out.layered += f.layered;
        for (const std::size_t part : f.parts) out.blocks[part] = 1;
    }
    for (const Followed& f : followed) out.onCasters += f.start && out.blocks[*f.start];
    return out;
}

}  // namespace penumbra
