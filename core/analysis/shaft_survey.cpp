#include "core/analysis/shaft_survey.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/analysis/convexity.hpp"
#include "core/trace/shaft.hpp"

namespace penumbra {
namespace {

/// Casters between one cluster and the light, and pairs of such over all clusters, up to which two
/// casters on one ray are looked into; beyond, there is no hope to exclude them.
constexpr std::size_t kMostBodies = 12, kMostPairs = 4096;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

struct Found {
    std::vector<char> casts, inTheWay, near, rises, risesClose;
    std::set<std::uint32_t> bodies;
    std::set<Pair> pairs;  ///< between one cluster and the light, the lesser first
    bool tooMany = false;

    void merge(const Found& o) {
        for (std::size_t p = 0; p < casts.size(); ++p) {
            casts[p] = casts[p] || o.casts[p];
            inTheWay[p] = inTheWay[p] || o.inTheWay[p];
            near[p] = near[p] || o.near[p];
            rises[p] = rises[p] || o.rises[p];
            risesClose[p] = risesClose[p] || o.risesClose[p];
        }
        bodies.insert(o.bodies.begin(), o.bodies.end());
        pairs.insert(o.pairs.begin(), o.pairs.end());
        tooMany = tooMany || o.tooMany || pairs.size() > kMostPairs;
    }
};

/// A box in front of the light, for a shaft: what is behind it blocks nothing.
Bounds inFront(Bounds box) {
    box.lo.z = std::max(box.lo.z, 1e-9 * std::max(box.hi.z, 1e-30));
    return box;
}

class Surveyor {
  public:
    using Questions = ShaftSurvey::Questions;

    Surveyor(const Geometry& geometry, const Receivers& receivers, const Casters& bodies,
             const Questions& questions)
        : geometry_(geometry),
          receivers_(receivers),
          bodies_(bodies),
          questions_(questions),
          space_(receivers.light()),
          corners_(receivers.light().corners()),
          halfLight_(receivers.light().halfU, receivers.light().halfV) {
        for (const glm::vec3& p : geometry.positions)
            vertices_.push_back(space_.point(glm::dvec3(p)));
        const bool all = questions.near || questions.layered;
        for (std::uint32_t t = 0, part = 0; t < geometry.triangleCount(); ++t) {
            while (3 * t >= geometry.parts[part].firstIndex + geometry.parts[part].indexCount)
                ++part;
            if (!all && questions.casts[part]) continue;
            const std::uint32_t* corner = &geometry.indices[3 * t];
            triangles_.push_back({corner[0], corner[1], corner[2]});
            partOf_.push_back(part);
        }
    }

    Found survey() const {
        const ShaftTree tree(vertices_, triangles_);
        Found nothing;
        nothing.casts = nothing.inTheWay = questions_.casts;
        for (std::vector<char>* of : {&nothing.near, &nothing.rises, &nothing.risesClose})
            of->resize(geometry_.parts.size(), 0);
        using Range = tbb::blocked_range<std::size_t>;
        return tbb::parallel_reduce(
            Range(0, receivers_.clusters().size()), nothing,
            [&](const Range& range, Found found) {
                std::vector<std::uint32_t> met;
                for (std::size_t c = range.begin(); c < range.end(); ++c)
                    look(receivers_.clusters()[c], tree, met, found);
                return found;
            },
            [](Found a, const Found& b) {
                a.merge(b);
                return a;
            });
    }

    /// Whether no ray meets two of the casters, or one of them twice. Only where all triangles were
    /// surveyed, so that they are numbered as the geometry's.
    bool provesSingle(const Found& found) const {
        if (found.tooMany || found.pairs.size() > kMostPairs) return false;
        std::map<std::uint32_t, std::vector<std::uint32_t>> trianglesOf;
        for (const std::uint32_t body : found.bodies) trianglesOf[body];
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            if (const auto body = trianglesOf.find(bodies_.ofVertex[triangles_[t][0]]);
                body != trianglesOf.end())
                body->second.push_back(t);
        std::map<std::uint32_t, Bounds> boxes;
        for (const auto& [body, triangles] : trianglesOf) {
            for (const std::uint32_t t : triangles)
                for (const std::uint32_t v : triangles_[t]) boxes[body].add(vertices_[v]);
            if (!isOneCaster(geometry_, triangles)) return false;
        }
        // Of two points on a ray the farther one's shaft holds the nearer one.
        const auto behind = [&](std::uint32_t far, std::uint32_t near) {
            const Shaft shaft(inFront(boxes[far]), halfLight_);
            return std::ranges::any_of(trianglesOf[near], [&](std::uint32_t t) {
                const auto& [a, b, c] = triangles_[t];
                return !shaft.misses(vertices_[a], vertices_[b], vertices_[c]);
            });
        };
        return std::ranges::none_of(found.pairs, [&](const Pair& pair) {
            return behind(pair.first, pair.second) || behind(pair.second, pair.first);
        });
    }

  private:
    void look(const Receivers::Cluster& cluster, const ShaftTree& tree,
              std::vector<std::uint32_t>& met, Found& found) const {
        const double clearM = questions_.clearance * cluster.box.hi.z;
        Bounds around = cluster.box;
        around.lo -= clearM;
        around.hi += clearM;
        const double besideM = questions_.beside * cluster.box.hi.z;
        Bounds texels = cluster.box;
        texels.lo -= glm::dvec3(besideM, besideM, 0.0);
        texels.hi += glm::dvec3(besideM, besideM, 0.0);
        const Shaft shaft(inFront(cluster.box), halfLight_), beside(inFront(texels), halfLight_);
        // A filter adds up what is beside a ray.
        const Shaft wide(inFront(around), halfLight_);
        tree.query(questions_.near ? wide : beside, met);
        std::vector<std::uint32_t> bodies;
        for (const std::uint32_t t : met) {
            const std::uint32_t part = partOf_[t];
            if (questions_.near && !(found.near[part] && found.risesClose[part])) {
                const bool close = isNear(t, cluster, around, clearM), rising = rises(t, cluster);
                found.near[part] = found.near[part] || close;
                found.rises[part] = found.rises[part] || rising;
                found.risesClose[part] = found.risesClose[part] || (close && rising);
            }
            const std::uint32_t body = bodies_.ofVertex[triangles_[t][0]];
            if (!found.inTheWay[part]) found.inTheWay[part] = mayBlock(t, cluster, beside, besideM);
            const bool isNew = questions_.layered && !found.tooMany &&
                               std::ranges::find(bodies, body) == bodies.end();
            if ((found.casts[part] && !isNew) || !mayBlock(t, cluster, shaft, 0.0)) continue;
            found.casts[part] = found.inTheWay[part] = 1;
            if (isNew) bodies.push_back(body);
        }
        if (!questions_.layered || found.tooMany) return;
        found.tooMany = bodies.size() > kMostBodies;
        if (found.tooMany) return;
        found.bodies.insert(bodies.begin(), bodies.end());
        for (const std::uint32_t a : bodies)
            for (const std::uint32_t b : bodies)
                if (a < b) found.pairs.emplace(a, b);
    }

    /// Heights of a triangle's corners over a plane: the least and the greatest.
    std::pair<double, double> heights(std::uint32_t t, const glm::dvec3& normal,
                                      double planeM) const {
        const auto& [a, b, c] = triangles_[t];
        const auto over = [&](std::uint32_t v) {
            return glm::dot(normal, glm::dvec3(geometry_.positions[v])) - planeM;
        };
        return std::minmax({over(a), over(b), over(c)});
    }

    bool isNear(std::uint32_t t, const Receivers::Cluster& cluster, const Bounds& around,
                double clearM) const {
        Bounds box;
        for (const std::uint32_t v : triangles_[t]) box.add(vertices_[v]);
        for (int axis = 0; axis < 3; ++axis)
            if (box.lo[axis] > around.hi[axis] || box.hi[axis] < around.lo[axis]) return false;
        if (!cluster.flat) return true;
        const auto [least, most] = heights(t, cluster.normal, cluster.planeM);
        return least <= clearM && most >= -clearM;
    }

    /// The light is above the points' plane, so that what lies below it is behind them.
    bool rises(std::uint32_t t, const Receivers::Cluster& cluster) const {
        return !cluster.flat ||
               heights(t, cluster.normal, cluster.planeM).second > questions_.toleranceM;
    }

    /// Whether the triangle may block a ray that ends as far beside a point of the cluster, and as
    /// much nearer to the light; `shaft` holds those.
    bool mayBlock(std::uint32_t t, const Receivers::Cluster& cluster, const Shaft& shaft,
                  double besideM) const {
        const auto& [a, b, c] = triangles_[t];
        if (shaft.misses(vertices_[a], vertices_[b], vertices_[c]) || !rises(t, cluster))
            return false;
        // Points and light on one side of the triangle's own plane: no ray crosses it.
        const glm::dvec3 p(geometry_.positions[a]);
        const glm::dvec3 across = glm::cross(glm::dvec3(geometry_.positions[b]) - p,
                                             glm::dvec3(geometry_.positions[c]) - p);
        const double length = glm::length(across);
        if (!(length > 0.0)) return false;
        const auto over = [&](const glm::dvec3& q) { return glm::dot(across, q - p) / length; };
        double least = 1e300, most = -1e300;
        const auto add = [&](const glm::dvec3& q, double aroundM) {
            least = std::min(least, over(q) - aroundM);
            most = std::max(most, over(q) + aroundM);
            return least < -questions_.toleranceM && most > questions_.toleranceM;
        };
        const auto addCorner = [&](const glm::dvec3& q) { return add(q, 0.0); };
        if (std::ranges::any_of(corners_, addCorner)) return true;
        // What is beside a point along the light is below a plane by the plane's slope, and above
        // it for being nearer to the light. Bias and texels are rounded.
        constexpr double kNearer = 0.95;
        const glm::dvec3 slope = glm::abs(space_.direction(across)) / length;
        const double aroundM = besideM * std::max(slope.x + slope.y - kNearer * slope.z, 0.0);
        return std::ranges::any_of(receivers_.points(cluster),
                                   [&](const glm::vec3& q) { return add(glm::dvec3(q), aroundM); });
    }

    const Geometry& geometry_;
    const Receivers& receivers_;
    const Casters& bodies_;
    const Questions& questions_;
    LightSpace space_;
    std::array<glm::dvec3, 4> corners_;
    glm::dvec2 halfLight_;
    std::vector<glm::dvec3> vertices_;  ///< in light space
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> partOf_;  ///< of each of triangles_
};

}  // namespace

ShaftSurvey ShaftSurvey::make(const Geometry& geometry, const Receivers& receivers,
                              const Casters& bodies, const Questions& questions) {
    const Surveyor surveyor(geometry, receivers, bodies, questions);
    Found found = surveyor.survey();
    ShaftSurvey out;
    out.layered = !questions.layered || !surveyor.provesSingle(found);
    out.casts = std::move(found.casts);
    out.inTheWay = std::move(found.inTheWay);
    const std::vector<char> all(geometry.parts.size(), 1);
    out.near = questions.near ? std::move(found.near) : all;
    out.rises = questions.near ? std::move(found.rises) : all;
    out.risesClose = questions.near ? std::move(found.risesClose) : all;
    return out;
}

}  // namespace penumbra
