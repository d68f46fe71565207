#include "core/frame/slice_view.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/error.hpp"
#include "core/frame/clipped_triangle.hpp"
#include "core/frame/light_view.hpp"

namespace penumbra {
namespace {

glm::dvec3 inLight(const SliceView& view, const glm::vec3& position) {
    const glm::dvec3 p = glm::dvec3(position) - view.centre;
    return {glm::dot(view.axisX, p), glm::dot(view.axisY, p), glm::dot(view.axisZ, p)};
}

/// The farthest receiver in each cell of the frustum's section: what is not well in front of those
/// around it casts no shadow that anyone sees.
class FarthestReceivers {
  public:
    FarthestReceivers(const Frame& frame, const SliceView& view)
        : view_(view), receivers_(kSide * kSide, glm::dvec3(0.0)) {
        for (const glm::vec3& receiver : frame.lightBounds.receivers) {
            const glm::dvec3 p = inLight(view, receiver);
            glm::dvec3& farthest = receivers_[index(cell(p))];
            if (p.z > farthest.z) farthest = p;
            if (p.z > farthest_.z) farthest_ = p;
        }
    }

    /// Adds the parts of a polygon that are at least `leastM` clear: the farthest receiver in the
    /// nine cells around a point (of all cells, if those have none) is that far below both the
    /// point and the polygon's plane, for what lies in one plane with its caster, as a slanting
    /// floor does, is not in its shadow. Asked of every point, so that cutting a polygon changes
    /// nothing.
    void addClear(const ClippedTriangle& polygon, double leastM,
                  std::vector<DepthExtent>& extents) const {
        glm::dvec3 doubled(0.0);
        const std::span<const glm::dvec3> points = polygon.points();
        for (std::size_t i = 2; i < points.size(); ++i)
            doubled += glm::cross(points[i - 1] - points[0], points[i] - points[0]);
        if (doubled == glm::dvec3(0.0)) return;
        const glm::dvec3 normal = glm::normalize(doubled);
        const Asked asked{normal, glm::dot(normal, points[0]),
                          leastM * std::max(std::abs(normal.z), 0x1p-20), leastM};
        glm::ivec2 first(kSide - 1), last(0);
        for (const glm::dvec3& p : points) {
            first = glm::min(first, cell(p));
            last = glm::max(last, cell(p));
        }
        addClear(polygon, asked, first, last, extents);
    }

  private:
    static constexpr int kSide = 48;
    // The frustum, two axes halved six times each, and what is clear in a cell.
    static_assert(6 + 2 * 6 + 1 <= ClippedTriangle::kMostPlanes && kSide <= 1 << 6);
    struct Asked {
        glm::dvec3 normal;
        double along;   ///< dot(normal, p) of the plane's points
        double belowM;  ///< distance of a receiver from the plane
        double clearM;  ///< and its depth below a point
    };
    static std::size_t index(glm::ivec2 c) { return static_cast<std::size_t>(c.y * kSide + c.x); }
    glm::ivec2 cell(const glm::dvec3& p) const {
        const glm::dvec2 uv = glm::dvec2(p) * view_.shrink(p.z) * view_.scale + view_.offset;
        return glm::clamp(glm::ivec2(uv * static_cast<double>(kSide)), 0, kSide - 1);
    }
    /// What is nearer than this is clear in a cell.
    double clearDepthM(const Asked& asked, glm::ivec2 c) const {
        double deepest = 0.0;
        bool any = false;
        const auto ask = [&](const glm::dvec3& receiver) {
            any = any || receiver.z > 0.0;
            if (std::abs(glm::dot(asked.normal, receiver) - asked.along) >= asked.belowM)
                deepest = std::max(deepest, receiver.z);
        };
        for (int y = std::max(c.y - 1, 0); y <= std::min(c.y + 1, kSide - 1); ++y)
            for (int x = std::max(c.x - 1, 0); x <= std::min(c.x + 1, kSide - 1); ++x)
                ask(receivers_[index({x, y})]);
        if (!any) ask(farthest_);
        return deepest - asked.clearM;
    }
    /// The plane uv[axis] = line / kSide; positive beyond.
    glm::dvec4 between(int axis, int line) const {
        const double uv = static_cast<double>(line) / kSide - view_.offset[axis];
        glm::dvec4 plane(0.0);
        plane[axis] = view_.scale[axis];
        if (view_.orthographic)
            plane.w = -uv;
        else {
            plane.z = -uv;
            plane.w = -uv * view_.copM;
        }
        return plane;
    }
    /// Halves the cells that the polygon lies in until all of it is clear, none, or they are one.
    void addClear(const ClippedTriangle& polygon, const Asked& asked, glm::ivec2 first,
                  glm::ivec2 last, std::vector<DepthExtent>& extents) const {
        const double nearM = polygon.nearM(), farM = polygon.farM();
        double least = std::numeric_limits<double>::infinity(), most = -least;
        const auto mixed = [&] { return nearM <= most && farM > least; };
        for (int y = first.y; y <= last.y && !mixed(); ++y)
            for (int x = first.x; x <= last.x && !mixed(); ++x) {
                const double depthM = clearDepthM(asked, {x, y});
                least = std::min(least, depthM);
                most = std::max(most, depthM);
            }
        if (nearM > most) return;
        if (!mixed()) {
            polygon.addTo(extents);
            return;
        }
        ClippedTriangle part = polygon;
        if (first == last) {
            part.clip({0, 0, -1, least});
            if (!part.empty()) part.addTo(extents);
            return;
        }
        const int axis = last.x - first.x >= last.y - first.y ? 0 : 1;
        const int middle = (first[axis] + last[axis] + 1) / 2;
        glm::ivec2 before = last, from = first;
        before[axis] = middle - 1;
        from[axis] = middle;
        ClippedTriangle beyond = polygon;
        part.clip(-between(axis, middle));
        beyond.clip(between(axis, middle));
        if (!part.empty()) addClear(part, asked, first, before, extents);
        if (!beyond.empty()) addClear(beyond, asked, from, last, extents);
    }

    const SliceView& view_;
    std::vector<glm::dvec3> receivers_;
    glm::dvec3 farthest_{0.0};  ///< of all: near the light, what is beside them shadows them, too
};

/// Sides of the frustum, the light's plane and that of the farthest receiver, inwards.
std::array<glm::dvec4, 6> volume(const SliceView& view) {
    // 0 <= uv <= 1, both times z + cop where the projection divides by it.
    const glm::dvec2 constant = view.orthographic ? glm::dvec2(1.0) : glm::dvec2(view.copM);
    const double slope = view.orthographic ? 0.0 : 1.0;
    const glm::dvec2 s = view.scale, o = view.offset, rest = 1.0 - o;
    return {{{s.x, 0, o.x * slope, o.x * constant.x},
             {-s.x, 0, rest.x * slope, rest.x * constant.x},
             {0, s.y, o.y * slope, o.y * constant.y},
             {0, -s.y, rest.y * slope, rest.y * constant.y},
             {0, 0, 1, 0},
             {0, 0, -1, view.farM}}};
}

/// The parts of casters' triangles inside the frustum, of each what `add` puts into the list.
template <class Add>
std::vector<DepthExtent> castersIn(const SliceView& view, const Frame& frame, const Add& add) {
    const Geometry& geometry = *frame.geometry;
    const std::array<glm::dvec4, 6> planes = volume(view);
    // Blocks in order, whichever thread does them: sums over casters are the same every time.
    constexpr std::size_t kBlock = 4096;
    const std::size_t triangles = geometry.triangleCount();
    std::vector<std::vector<DepthExtent>> found((triangles + kBlock - 1) / kBlock);
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t block) {
        for (std::size_t t = block * kBlock; t < std::min(triangles, (block + 1) * kBlock); ++t) {
            const std::uint32_t* corner = &geometry.indices[3 * t];
            ClippedTriangle polygon(inLight(view, geometry.positions[corner[0]]),
                                    inLight(view, geometry.positions[corner[1]]),
                                    inLight(view, geometry.positions[corner[2]]));
            for (const glm::dvec4& plane : planes) {
                polygon.clip(plane);
                if (polygon.empty()) break;
            }
            if (!polygon.empty()) add(polygon, found[block]);
        }
    });
    std::vector<DepthExtent> all;
    for (const std::vector<DepthExtent>& extents : found)
        all.insert(all.end(), extents.begin(), extents.end());
    return all;
}

/// Holds the ways between receivers and light at depths from `nearM` on.
void fitFrustum(SliceView& view, const Frame& frame, const SliceSettings& settings, double nearM) {
    const glm::dvec2 half(frame.light.halfU, frame.light.halfV);
    // Slopes of the lines from the light's edges that hold all receivers: x <= half + hi z.
    const glm::dvec2 hi = frame.lightBounds.fromCorners[1].hi,
                     lo = -frame.lightBounds.fromCorners[0].lo;
    const bool none = frame.lightBounds.whole.empty();
    const double steepest = none ? 0.0 : std::max({hi.x, hi.y, lo.x, lo.y});
    if (steepest > LightView::kMaxTangent)
        throw Unsupported(
            "receivers beyond 70 degrees off the light's normal do not fit the one frustum from "
            "behind the light that occlusion textures are sliced in");
    std::array<glm::dvec2, 2> window = {glm::dvec2(0.0), glm::dvec2(0.0)};
    if (view.orthographic) {
        // Of the receivers and the light.
        window = {glm::min(-half, frame.lightBounds.acrossLo),
                  glm::max(half, frame.lightBounds.acrossHi)};
    } else {
        // Where the scene is no wider than the light no distance is too far; past twice the depth
        // of the scene the frustum is straight enough.
        constexpr double kFarthest = 2.0;
        view.copM = 0.0;
        for (int axis = 0; axis < 2; ++axis) {
            const double slope = none ? 0.0 : std::max(lo[axis], hi[axis]);
            const double least = half[axis] / (kFarthest * view.farM);
            if (half[axis] > 0.0)
                view.copM = std::max(view.copM, half[axis] / std::max(slope, least));
        }
        view.copM *= settings.copFactor;
        // (half + slope z) / (z + cop) is monotone in z: its ends bound it.
        const auto at = [&](glm::dvec2 slope, double zM) {
            return (half + (none ? glm::dvec2(0.0) : slope) * zM) / (zM + view.copM);
        };
        const auto widest = [&](glm::dvec2 slope) {
            return glm::max(at(slope, nearM), at(slope, view.farM));
        };
        window = {-widest(lo), widest(hi)};
    }
    const glm::dvec2 middle = 0.5 * (window[0] + window[1]);
    const glm::dvec2 size =
        (window[1] - window[0]) *
        (settings.mapSize > 2 ? settings.mapSize / (settings.mapSize - 2.0) : 1.0);
    view.scale = 1.0 / size;
    view.offset = 0.5 - middle / size;
}

/// Depths at which the casters' area has reached k parts of all, evened out: a quarter of what
/// counts is the depth itself, so that no slice is thicker than four even ones.
void placeAtQuantiles(std::vector<double>& boundaries, const std::vector<DepthExtent>& casters,
                      double farM) {
    if (casters.empty()) return;
    boundaries[0] = std::ranges::min(casters, {}, &DepthExtent::nearM).nearM;
    constexpr std::size_t kBins = 1024;
    const double nearM = boundaries[0], binM = (farM - nearM) / kBins;
    std::vector<double> area(kBins, 0.0);
    double whole = 0.0;
    for (const DepthExtent& e : casters) {
        const auto bin = [&](double zM) {
            return std::min(static_cast<std::size_t>(std::max(zM - nearM, 0.0) / binM), kBins - 1);
        };
        const std::size_t first = bin(e.nearM), last = bin(e.farM);
        double before = 0.0;
        for (std::size_t b = first; b <= last; ++b) {
            const double reachedM2 =
                b == last ? e.areaM2 : e.areaNearer(nearM + binM * static_cast<double>(b + 1));
            area[b] += reachedM2 - before;
            before = reachedM2;
        }
        whole += e.areaM2;
    }
    if (whole == 0.0) return;
    double reached = 0.0;
    std::size_t next = 1;
    const auto parts = static_cast<double>(boundaries.size());
    for (std::size_t b = 0; b < kBins && next < boundaries.size(); ++b) {
        const double share = 0.75 * area[b] / whole + 0.25 / kBins;
        for (; next < boundaries.size() && reached + share >= static_cast<double>(next) / parts;
             ++next)
            boundaries[next] =
                nearM + binM * (static_cast<double>(b) +
                                (static_cast<double>(next) / parts - reached) / share);
        reached += share;
    }
}

/// Moves boundaries down to where a gap between casters in their slice ends, so that no slice
/// brings to one plane what lies apart. The part below the gap goes to the next slice.
void cutAtGaps(std::vector<double>& boundaries, std::vector<DepthExtent> casters) {
    std::ranges::sort(casters, {}, &DepthExtent::nearM);
    std::vector<std::array<double, 2>> gaps;
    double reachedM = boundaries[0];
    for (const DepthExtent& e : casters) {
        if (e.nearM > reachedM) gaps.push_back({reachedM, e.nearM});
        reachedM = std::max(reachedM, e.farM);
    }
    for (std::size_t k = 1; k < boundaries.size(); ++k)
        for (const auto& [fromM, toM] : gaps)
            if (fromM > boundaries[k - 1] && toM < boundaries[k]) {
                boundaries[k] = toM;
                break;
            }
}

void placeSlices(SliceView& view, const Frame& frame, const SliceSettings& settings) {
    const std::vector<DepthExtent> casters = castersIn(
        view, frame, [](const ClippedTriangle& polygon, std::vector<DepthExtent>& extents) {
            polygon.addTo(extents);
        });
    // Without a caster any depth will do; without depth there is nothing to cut.
    double nearM = view.farM * (1.0 - 0x1p-10);
    for (const DepthExtent& e : casters) nearM = std::min(nearM, e.nearM);
    const auto count = static_cast<std::size_t>(settings.slices);
    view.boundariesM.assign(count + 1, nearM);
    for (std::size_t k = 1; k <= count; ++k)
        view.boundariesM[k] =
            nearM + (view.farM - nearM) * static_cast<double>(k) / static_cast<double>(count + 1);
    if (settings.quantiles) {
        // Casters nearer to the receivers behind them than half an even slice (floors, above all)
        // are left out, for slices cannot tell the two apart.
        const double leastM = 0.5 * (view.farM - nearM) / static_cast<double>(count + 1);
        const FarthestReceivers receivers(frame, view);
        placeAtQuantiles(
            view.boundariesM,
            castersIn(view, frame,
                      [&](const ClippedTriangle& polygon, std::vector<DepthExtent>& extents) {
                          receivers.addClear(polygon, leastM, extents);
                      }),
            view.farM);
        cutAtGaps(view.boundariesM, casters);
    }
    view.planesM.assign(view.boundariesM.begin() + 1, view.boundariesM.end());
    if (!settings.snap) return;
    std::vector<double> deepest(count, 0.0);
    for (const DepthExtent& e : casters)
        for (std::size_t k = 0; k < count && view.boundariesM[k] <= e.farM; ++k)
            if (e.nearM < view.boundariesM[k + 1])
                deepest[k] = std::max(deepest[k], std::min(e.farM, view.boundariesM[k + 1]));
    for (std::size_t k = 0; k < count; ++k)
        if (deepest[k] > 0.0) view.planesM[k] = deepest[k];
}

}  // namespace

SliceView SliceView::fit(const Frame& frame, const SliceSettings& settings) {
    SliceView view;
    const std::array<glm::dvec3, 3> axes = lightSideAxes(frame.light, 0);
    view.centre = frame.light.centre;
    view.axisX = axes[0];
    view.axisY = axes[1];
    view.axisZ = axes[2];
    view.orthographic = settings.orthographic;
    if (!frame.lightBounds.whole.empty()) view.farM = frame.lightBounds.whole.receiverFarM;
    // Which casters there are decides how near to the light the frustum has to be wide enough: the
    // first frustum holds the light itself, from where that is no wider than the scene.
    SliceSettings whole = settings;
    whole.copFactor = 1.0;
    fitFrustum(view, frame, whole, 0.0);
    placeSlices(view, frame, settings);
    fitFrustum(view, frame, settings, view.planesM[0]);
    return view;
}

glm::mat4 SliceView::clipFromWorld() const {
    const glm::dvec4 x(axisX, -glm::dot(axisX, centre)), y(axisY, -glm::dot(axisY, centre)),
        z(axisZ, -glm::dot(axisZ, centre)), one(0, 0, 0, 1);
    const glm::dvec4 w = orthographic ? one : z + copM * one;
    // 0 <= clip.z <= clip.w: from the light's plane on, to the farthest receiver or without end.
    const glm::dvec4 depth = orthographic ? z / farM : z;
    return glm::mat4(
        glm::transpose(glm::dmat4(2.0 * scale.x * x + (2.0 * offset.x - 1.0) * w,
                                  2.0 * scale.y * y + (2.0 * offset.y - 1.0) * w, depth, w)));
}

glm::dvec2 SliceView::kernelUv(const AreaLight& light, double zM, double planeM) const {
    return 2.0 * glm::dvec2(light.halfU, light.halfV) * (1.0 - planeM / zM) * shrink(planeM) *
           scale;
}

}  // namespace penumbra
