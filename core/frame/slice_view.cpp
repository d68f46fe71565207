#include "core/frame/slice_view.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/frame/light_view.hpp"

namespace penumbra {
namespace {

/// The part of a caster's triangle inside the frustum.
struct Extent {
    double nearM, farM, areaM2;
    double clearanceM;     ///< from its middle to the farthest receiver behind
    double middleM = 0.0;  ///< depth of the corner between the nearest and the farthest

    /// How much of a triangle's area is nearer than `zM`: its width is linear in depth on both
    /// sides of the middle corner, so that cutting it in parts changes nothing.
    double areaNearer(double zM) const {
        if (zM <= nearM) return 0.0;
        if (zM >= farM) return areaM2;
        const double depthM = farM - nearM, before = zM - nearM, behind = farM - zM;
        return zM < middleM ? areaM2 * before * before / ((middleM - nearM) * depthM)
                            : areaM2 - areaM2 * behind * behind / ((farM - middleM) * depthM);
    }
};

glm::dvec3 inLight(const SliceView& view, const glm::vec3& position) {
    const glm::dvec3 p = glm::dvec3(position) - view.centre;
    return {glm::dot(view.axisX, p), glm::dot(view.axisY, p), glm::dot(view.axisZ, p)};
}

template <class Visit>
void forEachReceiver(const Frame& frame, const SliceView& view, std::size_t stride,
                     const Visit& visit) {
    for (std::size_t i = 0; i < frame.gbuffer.size(); i += stride)
        if (frame.gbuffer.mask[i] == PixelClass::scored ||
            frame.gbuffer.mask[i] == PixelClass::horizon)
            visit(inLight(view, frame.gbuffer.position[i]));
}

/// The farthest receiver in each cell of the frustum's section: what is not well in front of those
/// around it casts no shadow that anyone sees.
class FarthestReceivers {
  public:
    FarthestReceivers(const Frame& frame, const SliceView& view)
        : view_(view), receivers_(kSide * kSide, glm::dvec3(0.0)) {
        // Some ten thousand points are enough to find a cell's depth.
        constexpr std::size_t kPoints = 20000;
        const std::size_t stride = 1 + frame.gbuffer.size() / kPoints;
        forEachReceiver(frame, view, stride, [&](const glm::dvec3& p) {
            glm::dvec3& farthest = receivers_[index(cell(p))];
            if (p.z > farthest.z) farthest = p;
        });
    }
    /// By how much the farthest receiver around a plane's point `p` is below both the point and the
    /// plane: what lies in one plane with its caster, as a slanting floor does, is not in its
    /// shadow.
    double clearanceM(const glm::dvec3& p, const glm::dvec3& normal) const {
        double most = 0.0;
        const glm::ivec2 c = cell(p);
        for (int y = std::max(c.y - 1, 0); y <= std::min(c.y + 1, kSide - 1); ++y)
            for (int x = std::max(c.x - 1, 0); x <= std::min(c.x + 1, kSide - 1); ++x) {
                const glm::dvec3 from = receivers_[index({x, y})] - p;
                const double belowPlane = std::abs(glm::dot(normal, from));
                most = std::max(
                    most, std::min(from.z, belowPlane / std::max(std::abs(normal.z), 0x1p-20)));
            }
        return most;
    }

  private:
    static constexpr int kSide = 48;
    static std::size_t index(glm::ivec2 c) { return static_cast<std::size_t>(c.y * kSide + c.x); }
    glm::ivec2 cell(const glm::dvec3& p) const {
        const glm::dvec2 uv = glm::dvec2(p) * view_.shrink(p.z) * view_.scale + view_.offset;
        return glm::clamp(glm::ivec2(uv * static_cast<double>(kSide)), 0, kSide - 1);
    }
    const SliceView& view_;
    std::vector<glm::dvec3> receivers_;
};

/// A triangle clipped to a convex volume by Sutherland and Hodgman.
class Polygon {
  public:
    Polygon(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) : points_{a, b, c} {}

    /// Keeps the part with dot(plane, (p, 1)) >= 0.
    void clip(const glm::dvec4& plane) {
        std::array<glm::dvec3, kMost> kept;
        int count = 0;
        const auto height = [&](const glm::dvec3& p) {
            return glm::dot(glm::dvec3(plane), p) + plane.w;
        };
        for (int i = 0; i < count_; ++i) {
            const glm::dvec3 &from = at(i), &to = at((i + 1) % count_);
            const double h0 = height(from), h1 = height(to);
            if (h0 >= 0.0) kept[static_cast<std::size_t>(count++)] = from;
            if ((h0 > 0.0 && h1 < 0.0) || (h0 < 0.0 && h1 > 0.0))
                kept[static_cast<std::size_t>(count++)] = from + h0 / (h0 - h1) * (to - from);
        }
        points_ = kept;
        count_ = count;
    }
    bool empty() const { return count_ == 0; }
    /// From its middle to the farthest receiver behind; 0 without an area.
    double clearanceM(const FarthestReceivers& receivers) const {
        glm::dvec3 middle(0.0);
        glm::dvec3 doubled(0.0);
        for (int i = 0; i < count_; ++i) {
            middle += at(i) / static_cast<double>(count_);
            doubled += glm::cross(at(i) - at(0), at((i + 1) % count_) - at(0));
        }
        if (doubled == glm::dvec3(0.0)) return 0.0;
        return receivers.clearanceM(middle, glm::normalize(doubled));
    }
    /// Adds the triangles that it consists of, all with its own clearance; none without an area,
    /// for that is drawn nowhere and must not draw planes to its depth.
    void addTo(std::vector<Extent>& extents, const FarthestReceivers& receivers) const {
        const double clearance = clearanceM(receivers);
        for (int i = 1; i + 1 < count_; ++i) {
            std::array<double, 3> z = {at(0).z, at(i).z, at(i + 1).z};
            std::ranges::sort(z);
            const double areaM2 = 0.5 * glm::length(glm::cross(at(i) - at(0), at(i + 1) - at(0)));
            if (areaM2 > 0.0) extents.push_back({z[0], z[2], areaM2, clearance, z[1]});
        }
    }

  private:
    static constexpr std::size_t kMost = 9;  // three corners and one more for each of six planes
    const glm::dvec3& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
    std::array<glm::dvec3, kMost> points_;
    int count_ = 3;
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

std::vector<Extent> castersIn(const SliceView& view, const Frame& frame) {
    const Geometry& geometry = *frame.geometry;
    const std::array<glm::dvec4, 6> planes = volume(view);
    const FarthestReceivers receivers(frame, view);
    // Blocks in order, whichever thread does them: sums over casters are the same every time.
    constexpr std::size_t kBlock = 4096;
    const std::size_t triangles = geometry.triangleCount();
    std::vector<std::vector<Extent>> found((triangles + kBlock - 1) / kBlock);
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t block) {
        for (std::size_t t = block * kBlock; t < std::min(triangles, (block + 1) * kBlock); ++t) {
            const std::uint32_t* corner = &geometry.indices[3 * t];
            Polygon polygon(inLight(view, geometry.positions[corner[0]]),
                            inLight(view, geometry.positions[corner[1]]),
                            inLight(view, geometry.positions[corner[2]]));
            for (const glm::dvec4& plane : planes) {
                polygon.clip(plane);
                if (polygon.empty()) break;
            }
            if (!polygon.empty()) polygon.addTo(found[block], receivers);
        }
    });
    std::vector<Extent> all;
    for (const std::vector<Extent>& extents : found)
        all.insert(all.end(), extents.begin(), extents.end());
    return all;
}

/// Receivers and the light in light coordinates x, y.
std::array<glm::dvec2, 2> acrossOf(const Frame& frame, const SliceView& view) {
    const glm::dvec2 half(frame.light.halfU, frame.light.halfV);
    std::array<glm::dvec2, 2> bounds = {-half, half};
    forEachReceiver(frame, view, 1, [&](const glm::dvec3& p) {
        bounds = {glm::min(bounds[0], glm::dvec2(p)), glm::max(bounds[1], glm::dvec2(p))};
    });
    return bounds;
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
        window = acrossOf(frame, view);
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
/// counts is the depth itself, so that no slice is thicker than four even ones. Casters nearer to
/// the receivers behind them than half an even slice (floors, above all) are left out, for slices
/// cannot tell the two apart.
void placeAtQuantiles(std::vector<double>& boundaries, std::vector<Extent> casters, double farM) {
    const double least = 0.5 * (farM - boundaries[0]) / static_cast<double>(boundaries.size());
    std::erase_if(casters, [&](const Extent& e) { return e.clearanceM < least; });
    if (casters.empty()) return;
    boundaries[0] = std::ranges::min(casters, {}, &Extent::nearM).nearM;
    constexpr std::size_t kBins = 1024;
    const double nearM = boundaries[0], binM = (farM - nearM) / kBins;
    std::vector<double> area(kBins, 0.0);
    double whole = 0.0;
    for (const Extent& e : casters) {
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
void cutAtGaps(std::vector<double>& boundaries, std::vector<Extent> casters) {
    std::ranges::sort(casters, {}, &Extent::nearM);
    std::vector<std::array<double, 2>> gaps;
    double reachedM = boundaries[0];
    for (const Extent& e : casters) {
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

void placeSlices(SliceView& view, const std::vector<Extent>& casters,
                 const SliceSettings& settings) {
    // Without a caster any depth will do; without depth there is nothing to cut.
    double nearM = view.farM * (1.0 - 0x1p-10);
    for (const Extent& e : casters) nearM = std::min(nearM, e.nearM);
    const auto count = static_cast<std::size_t>(settings.slices);
    view.boundariesM.assign(count + 1, nearM);
    for (std::size_t k = 1; k <= count; ++k)
        view.boundariesM[k] =
            nearM + (view.farM - nearM) * static_cast<double>(k) / static_cast<double>(count + 1);
    if (settings.quantiles) {
        placeAtQuantiles(view.boundariesM, casters, view.farM);
        cutAtGaps(view.boundariesM, casters);
    }
    view.planesM.assign(view.boundariesM.begin() + 1, view.boundariesM.end());
    if (!settings.snap) return;
    std::vector<double> deepest(count, 0.0);
    for (const Extent& e : casters)
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
    placeSlices(view, castersIn(view, frame), settings);
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
