#include "harness/metrics/edge_scan.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

constexpr double kPlaneTolerance = 1e-3;  ///< of the segment's length

struct Sample {
    double positionM;
    std::uint32_t pixel;
};

/// In order of position.
std::vector<Sample> samplesOf(const ShadowEdge& edge, const GBuffer& gbuffer) {
    const double length = glm::distance(edge.from, edge.to);
    const glm::dvec3 along = (edge.to - edge.from) / length;
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored) continue;
        const glm::dvec3 fromStart = glm::dvec3(gbuffer.position[i]) - edge.from;
        const glm::dvec3 normal(gbuffer.geometricNormal[i]);
        const double offStart = glm::dot(normal, fromStart);
        const double offEnd = offStart - length * glm::dot(normal, along);
        if (!(std::max(std::abs(offStart), std::abs(offEnd)) <= kPlaneTolerance * length)) continue;
        const double position = glm::dot(fromStart, along);
        const double aside = glm::length(fromStart - position * along);
        if (position < 0.0 || position > length || aside > edge.halfWidthM) continue;
        samples.push_back({position, static_cast<std::uint32_t>(i)});
    }
    std::ranges::sort(samples, {}, &Sample::positionM);
    return samples;
}

}  // namespace

EdgeScan scanEdge(const ShadowEdge& edge, const GBuffer& gbuffer) {
    const std::vector<Sample> samples = samplesOf(edge, gbuffer);
    EdgeScan scan;
    if (samples.empty() || samples.front().positionM == samples.back().positionM) return scan;
    const double first = samples.front().positionM;
    const double extentM = samples.back().positionM - first;
    // The receiver's area over its pixels is the area of a footprint.
    const double areaM2 = 2.0 * edge.halfWidthM * extentM;
    const double footprintM = std::sqrt(areaM2 / static_cast<double>(samples.size()));
    const double bins = std::max(1.0, std::floor(extentM / footprintM));

    double filled = -1.0, sum = 0.0;
    for (const Sample& s : samples) {
        const double bin = std::min(bins - 1.0, std::floor((s.positionM - first) / extentM * bins));
        if (bin > filled) {
            filled = bin;
            sum = 0.0;
            scan.positionsM.push_back(0.0);
            scan.pixels.emplace_back();
        }
        sum += s.positionM;
        scan.pixels.back().push_back(s.pixel);
        scan.positionsM.back() = sum / static_cast<double>(scan.pixels.back().size());
    }
    return scan;
}

std::optional<EdgeProfile> EdgeScan::measured(std::span<const float> image) const {
    std::vector<double> means;
    means.reserve(pixels.size());
    for (const std::vector<std::uint32_t>& bin : pixels) {
        double sum = 0.0;
        for (const std::uint32_t pixel : bin) sum += image[pixel];
        means.push_back(sum / static_cast<double>(bin.size()));
    }
    return measureEdge(positionsM, means);
}

}  // namespace penumbra
