#include "harness/reference/exact.hpp"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>

#include "core/error.hpp"
#include "core/trace/shaft.hpp"
#include "harness/reference/exact_irradiance.hpp"
#include "harness/reference/exact_outline.hpp"
#include "harness/reference/exact_union.hpp"

namespace penumbra {

namespace {

/// Side of the largest group of pixels that share a shaft; groups are split into four down to one
/// pixel where that pays.
constexpr int kTile = 16;
constexpr int kLevels = 5;
/// Not worth splitting for.
constexpr std::size_t kFewEdges = 64;
/// Looking at a triangle again for a smaller group costs about as much as this many edges.
constexpr std::size_t kTriangleCost = 12;
/// Areas add up to 0 or 1 but for this.
constexpr double kRounding = 1e-12;
/// Width over length that stands for a light of no width.
constexpr double kNarrow = 1e-6;
/// Light so small, in solid angle, that Lambert's sum over its edges loses more digits than the
/// visible share of its area differs from that of its irradiance.
constexpr double kSmallLight = 1e-8;

struct Rect {
    int x0, y0, x1, y1;
    int side() const { return std::max(x1 - x0, y1 - y0); }
};

/// One pixel's point.
struct Receiver {
    std::size_t pixel;
    glm::dvec3 origin;  ///< of its shadow rays, in light space
};

/// The greatest coordinate of any vertex.
double reachOf(const Geometry& geometry) {
    const Bounds bounds = boundsOf(geometry.positions);
    if (bounds.empty()) return 0.0;
    const glm::dvec3 far = glm::max(glm::abs(bounds.lo), glm::abs(bounds.hi));
    return std::max({far.x, far.y, far.z});
}

class ExactTracer {
  public:
    ExactTracer(const Tracer& tracer, const GBuffer& gbuffer, const AreaLight& light,
                const ExactOptions& options, Reference& out, std::vector<char>& tooMany)
        : gbuffer_(gbuffer),
          space_(light),
          halfLight_(std::max(light.halfU, kNarrow * light.halfV),
                     std::max(light.halfV, kNarrow * light.halfU)),
          isPoint_(light.isPoint()),
          options_(options),
          reach_(reachOf(tracer.geometry())),
          mesh_(tracer.geometry(), light),
          tree_(mesh_.vertices, mesh_.triangles),
          out_(out),
          tooMany_(tooMany),
          workers_([this] { return Worker(mesh_, halfLight_); }) {}

    void tile(const Rect& rect) {
        const std::vector<Receiver> receivers = receiversIn(rect);
        if (receivers.empty()) return;
        Worker& worker = workers_.local();
        tree_.query(shaftOf(receivers), worker.candidates[0]);
        if (isPoint_)
            seeCentre(receivers, worker.candidates[0]);
        else
            see(rect, receivers, 0, worker);
    }

  private:
    /// What a thread keeps between tiles.
    struct Worker {
        Worker(const CasterMesh& mesh, const glm::dvec2& halfLight) : outline(mesh, halfLight) {}
        Outline outline;
        UnionSweep sweep;
        std::array<std::vector<std::uint32_t>, kLevels> candidates;  ///< per depth of splitting
    };

    std::vector<Receiver> receiversIn(const Rect& rect) const {
        std::vector<Receiver> receivers;
        for (int y = rect.y0; y < rect.y1; ++y)
            for (int x = rect.x0; x < rect.x1; ++x) {
                const std::size_t i = static_cast<std::size_t>(y) * gbuffer_.width + x;
                if (!isAsked(gbuffer_.mask[i])) continue;
                const Receiver receiver{i, space_.point(lifted(i))};
                // On the light's plane nothing is in between.
                if (receiver.origin.z > 0.0) receivers.push_back(receiver);
            }
        return receivers;
    }

    /// Off the surface by four times what rounding to float may have sunk the pixel's point below
    /// it, and by a trifle where that is nothing, as on a floor through the origin.
    glm::dvec3 lifted(std::size_t pixel) const {
        const glm::dvec3 position(gbuffer_.position[pixel]);
        const glm::dvec3 normal(gbuffer_.geometricNormal[pixel]);
        const double rounding = glm::dot(glm::abs(normal), glm::abs(position));
        return position + (0x1p-22 * rounding + 0x1p-26 * reach_) * normal;
    }

    static Bounds boundsOf(const std::vector<Receiver>& receivers) {
        Bounds bounds;
        for (const Receiver& receiver : receivers) bounds.add(receiver.origin);
        return bounds;
    }

    Shaft shaftOf(const std::vector<Receiver>& receivers) const {
        return {boundsOf(receivers), isPoint_ ? glm::dvec2(0.0) : halfLight_};
    }

    void set(std::size_t pixel, double visibility, double shading) const {
        out_.visibility[pixel] = static_cast<float>(visibility);
        out_.irradiance[pixel] = static_cast<float>(shading * out_.irradianceUnshadowed[pixel]);
    }

    /// Sets the receivers' values; candidates[depth] holds the triangles.
    void see(const Rect& rect, const std::vector<Receiver>& receivers, std::size_t depth,
             Worker& worker) const {
        const std::vector<std::uint32_t>& candidates = worker.candidates[depth];
        if (candidates.empty()) return;
        worker.outline.prepare(boundsOf(receivers), candidates);
        const std::size_t cost = worker.outline.cost();
        if (rect.side() > 1 && cost > kFewEdges &&
            cost * receivers.size() > kTriangleCost * candidates.size()) {
            split(rect, depth, worker);
            return;
        }
        for (const Receiver& receiver : receivers) {
            worker.outline.project(receiver.origin, worker.sweep);
            if (worker.sweep.size() > options_.maxEdges)
                tooMany_[receiver.pixel] = 1;
            else
                measure(receiver, worker.sweep.covered());
        }
    }

    void split(const Rect& rect, std::size_t depth, Worker& worker) const {
        const int half = (rect.side() + 1) / 2;
        for (int y = rect.y0; y < rect.y1; y += half)
            for (int x = rect.x0; x < rect.x1; x += half) {
                const Rect quarter{x, y, std::min(x + half, rect.x1), std::min(y + half, rect.y1)};
                const std::vector<Receiver> receivers = receiversIn(quarter);
                if (receivers.empty()) continue;
                const Shaft shaft = shaftOf(receivers);
                std::vector<std::uint32_t>& left = worker.candidates[depth + 1];
                left.clear();
                for (const std::uint32_t triangle : worker.candidates[depth]) {
                    const auto& [a, b, c] = mesh_.triangles[triangle];
                    if (!shaft.misses(mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]))
                        left.push_back(triangle);
                }
                see(quarter, receivers, depth + 1, worker);
            }
    }

    void measure(const Receiver& receiver, const std::vector<Strip>& covered) const {
        double hidden = 0.0;
        for (const Strip& strip : covered) hidden += strip.signedArea();
        if (hidden < kRounding) return;
        if (hidden > 1.0 - kRounding) {
            set(receiver.pixel, 0.0, 0.0);
            return;
        }
        const std::size_t i = receiver.pixel;
        const glm::dvec3 position = space_.point(glm::dvec3(gbuffer_.position[i]));
        const glm::dvec3 normal = space_.direction(glm::dvec3(gbuffer_.geometricNormal[i]));
        const double visibility = 1.0 - hidden;
        const bool isSmall =
            glm::dot(halfLight_, halfLight_) < kSmallLight * glm::dot(position, position);
        set(i, visibility,
            isSmall ? visibility : uncoveredIrradiance(covered, position, normal, halfLight_));
    }

    /// Whether the triangle meets the segment from `origin` to the light's centre.
    bool blocksCentre(std::uint32_t triangle, const glm::dvec3& origin) const {
        const auto& [ia, ib, ic] = mesh_.triangles[triangle];
        const glm::dvec3 a = mesh_.vertices[ia] - origin, b = mesh_.vertices[ib] - origin,
                         c = mesh_.vertices[ic] - origin;
        // Volumes on the two sides of a shared edge are each other's negative to the last bit, so
        // that nothing slips through between neighbours.
        const double u = glm::dot(origin, glm::cross(a, b)), v = glm::dot(origin, glm::cross(b, c)),
                     w = glm::dot(origin, glm::cross(c, a));
        if (!((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)))
            return false;
        const double sum = u + v + w;
        if (sum == 0.0) return false;
        const double height = -(u * c.z + v * a.z + w * b.z) / sum;  // above the point
        return height > Outline::kPointMargin * origin.z &&
               height < (1.0 - Outline::kLightMargin) * origin.z;
    }

    void seeCentre(const std::vector<Receiver>& receivers,
                   const std::vector<std::uint32_t>& candidates) const {
        for (const Receiver& receiver : receivers)
            if (std::any_of(candidates.begin(), candidates.end(), [&](std::uint32_t triangle) {
                    return blocksCentre(triangle, receiver.origin);
                }))
                set(receiver.pixel, 0.0, 0.0);
    }

    const GBuffer& gbuffer_;
    LightSpace space_;
    glm::dvec2 halfLight_;
    bool isPoint_;
    const ExactOptions& options_;
    double reach_;
    CasterMesh mesh_;
    ShaftTree tree_;
    Reference& out_;
    std::vector<char>& tooMany_;
    tbb::enumerable_thread_specific<Worker> workers_;
};

/// Traces the pixels marked in `wanted` and puts them into `out`.
void traceInstead(const Tracer& tracer, const GBuffer& gbuffer, const AreaLight& light,
                  const std::vector<char>& wanted, const ReferenceOptions& options,
                  const Progress& progress, Reference& out) {
    GBuffer rest = gbuffer;
    for (std::size_t i = 0; i < rest.size(); ++i)
        if (!wanted[i]) rest.mask[i] = PixelClass::background;
    const Reference traced = traceReference(tracer, rest, light, options, progress);
    for (std::size_t i = 0; i < rest.size(); ++i) {
        if (!wanted[i]) continue;
        out.visibility[i] = traced.visibility[i];
        out.standardError[i] = traced.standardError[i];
        out.rays[i] = traced.rays[i];
        out.irradiance[i] = traced.irradiance[i];
    }
}

}  // namespace

const Material* firstMasked(const Geometry& geometry, const std::vector<Material>& materials) {
    for (const Part& part : geometry.parts)
        if (materials[part.material].masked && part.indexCount > 0)
            return &materials[part.material];
    return nullptr;
}

void refuseMasked(const Geometry& geometry, const std::vector<Material>& materials) {
    if (const Material* masked = firstMasked(geometry, materials))
        throw InputError(
            fmt::format("--reference exact: material '{}' is alpha-masked; exact visibility knows "
                        "polygons only, use --reference embree",
                        masked->name));
}

Reference exactReference(const Tracer& tracer, const std::vector<Material>& materials,
                         const GBuffer& gbuffer, const AreaLight& light,
                         const ExactOptions& options, const Progress& progress, ExactStats* stats) {
    refuseMasked(tracer.geometry(), materials);
    Reference out = unshadowedReference(gbuffer);
    std::vector<char> tooMany(gbuffer.size(), 0);
    ExactTracer exact(tracer, gbuffer, light, options, out, tooMany);

    const int columns = (gbuffer.width + kTile - 1) / kTile;
    const int tiles = columns * ((gbuffer.height + kTile - 1) / kTile);
    std::atomic<int> done{0};
    std::mutex reporting;
    tbb::parallel_for(0, tiles, [&](int t) {
        const int x = t % columns * kTile, y = t / columns * kTile;
        exact.tile({x, y, std::min(x + kTile, gbuffer.width), std::min(y + kTile, gbuffer.height)});
        const double share = static_cast<double>(++done) / tiles;
        const std::unique_lock lock(reporting, std::try_to_lock);
        if (progress && lock) progress(share);
    });

    const auto traced = static_cast<std::size_t>(std::count(tooMany.begin(), tooMany.end(), 1));
    if (traced > 0) traceInstead(tracer, gbuffer, light, tooMany, options.fallback, progress, out);
    if (progress) progress(1.0);
    if (stats) {
        stats->tracedPixels = traced;
        stats->exactPixels =
            gbuffer.count(PixelClass::scored) + gbuffer.count(PixelClass::horizon) - traced;
    }
    return out;
}

}  // namespace penumbra
