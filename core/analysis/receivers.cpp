#include "core/analysis/receivers.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/trace/shaft.hpp"

namespace penumbra {
namespace {

constexpr int kSquare = 16;  // pixels
/// Planes that a square may show; what lies on further ones is one cluster without a plane.
constexpr std::size_t kMostPlanes = 6;
/// Planes with fewer points than this share that cluster too: on finely tessellated surfaces there
/// is one for every other pixel, and each would be looked at apart.
constexpr std::size_t kFewestPoints = 24;
/// Per component: normals of coplanar triangles agree to rounding.
constexpr float kSameNormal = 1e-6f;

/// A cluster while its points are gathered.
struct Gathering {
    Receivers::Cluster cluster;
    std::vector<glm::vec3> points;
};

/// The clusters of the square whose upper left pixel is (x0, y0).
std::vector<Gathering> clustersOf(const GBuffer& gbuffer, const LightSpace& space, int x0, int y0) {
    std::vector<Gathering> found;
    std::array<glm::vec3, kMostPlanes> normals;
    Gathering others;
    const auto put = [&](Gathering& to, const glm::vec3& position, const glm::dvec3& inLightSpace) {
        to.cluster.box.add(inLightSpace);
        to.points.push_back(position);
    };
    for (int y = y0; y < std::min(y0 + kSquare, gbuffer.height); ++y)
        for (int x = x0; x < std::min(x0 + kSquare, gbuffer.width); ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * gbuffer.width + x;
            if (!isAsked(gbuffer.mask[i])) continue;
            const glm::vec3 position = gbuffer.position[i], normal = gbuffer.geometricNormal[i];
            const glm::dvec3 inLightSpace = space.point(glm::dvec3(position));
            if (inLightSpace.z <= 0.0) continue;
            // Part of the light is below a horizon pixel's plane: no plane clears it.
            std::size_t k = gbuffer.mask[i] == PixelClass::scored ? 0 : kMostPlanes;
            const double heightM = glm::dot(glm::dvec3(normal), glm::dvec3(position));
            const double toleranceM =
                8.0 * std::numeric_limits<float>::epsilon() * glm::length(glm::dvec3(position));
            for (; k < found.size(); ++k) {
                const Receivers::Cluster& c = found[k].cluster;
                const glm::vec3 apart = glm::abs(normals[k] - normal);
                if (std::max({apart.x, apart.y, apart.z}) <= kSameNormal &&
                    std::abs(glm::dot(c.normal, glm::dvec3(position)) - c.planeM) <= toleranceM)
                    break;
            }
            if (k < found.size()) {
                Receivers::Cluster& c = found[k].cluster;
                c.planeM = std::min(c.planeM, glm::dot(c.normal, glm::dvec3(position)));
            } else if (k < kMostPlanes) {
                normals[k] = normal;
                Gathering& fresh = found.emplace_back();
                fresh.cluster.flat = true;
                fresh.cluster.normal = glm::dvec3(normal);
                fresh.cluster.planeM = heightM;
            }
            put(k < kMostPlanes ? found[k] : others, position, inLightSpace);
        }
    const auto tooFew = [&](const Gathering& g) {
        if (g.points.size() >= kFewestPoints) return false;
        others.cluster.box.add(g.cluster.box.lo);
        others.cluster.box.add(g.cluster.box.hi);
        others.points.insert(others.points.end(), g.points.begin(), g.points.end());
        return true;
    };
    // A square that shows one plane only, however little of it, needs no other cluster.
    if (found.size() > 1 || !others.points.empty()) std::erase_if(found, tooFew);
    if (!others.points.empty()) found.push_back(std::move(others));
    return found;
}

}  // namespace

void Receivers::add(const GBuffer& gbuffer) {
    const LightSpace space(light_);
    const int columns = (gbuffer.width + kSquare - 1) / kSquare;
    const int rows = (gbuffer.height + kSquare - 1) / kSquare;
    std::vector<std::vector<Gathering>> squares(static_cast<std::size_t>(columns) * rows);
    tbb::parallel_for(std::size_t{0}, squares.size(), [&](std::size_t s) {
        const int column = static_cast<int>(s) % columns, row = static_cast<int>(s) / columns;
        squares[s] = clustersOf(gbuffer, space, column * kSquare, row * kSquare);
    });
    for (std::vector<Gathering>& square : squares)
        for (Gathering& g : square) {
            g.cluster.first = static_cast<std::uint32_t>(points_.size());
            g.cluster.count = static_cast<std::uint32_t>(g.points.size());
            points_.insert(points_.end(), g.points.begin(), g.points.end());
            clusters_.push_back(g.cluster);
        }
    sawHorizon_ = sawHorizon_ || gbuffer.count(PixelClass::horizon) > 0;
    const std::vector<std::size_t> asked = gbuffer.asked();
    const std::size_t count = std::min(asked.size(), kSamples);
    for (std::size_t k = 0; k < count; ++k) {
        // In the middle of its stretch.
        const std::size_t i = asked[(2 * k + 1) * asked.size() / (2 * count)];
        samples_.push_back({gbuffer.position[i], gbuffer.geometricNormal[i]});
    }
}

std::vector<Receivers::Sample> Receivers::samples() const {
    const std::size_t count = std::min(samples_.size(), kSamples);
    std::vector<Sample> chosen;
    for (std::size_t k = 0; k < count; ++k)
        chosen.push_back(samples_[(2 * k + 1) * samples_.size() / (2 * count)]);
    return chosen;
}

}  // namespace penumbra
