#include "harness/reference/exact_outline.hpp"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace penumbra {

namespace {

/// For each position the number of its place, places being numbered from 0.
std::vector<std::uint32_t> placesOf(const std::vector<glm::vec3>& positions,
                                    std::vector<glm::vec3>& places) {
    std::vector<std::uint32_t> order(positions.size()), place(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
        const glm::vec3& p = positions[i];
        return std::tuple(p.x, p.y, p.z);
    };
    // By index, too: -0 and 0 are one place, and the first of them gives it.
    tbb::parallel_sort(order, [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(key(a), a) < std::tuple(key(b), b);
    });
    for (const std::uint32_t i : order) {
        if (places.empty() || places.back() != positions[i]) places.push_back(positions[i]);
        place[i] = static_cast<std::uint32_t>(places.size() - 1);
    }
    return place;
}

/// The point of the segment where `height` is 0; `heightA` and `heightB` differ in sign.
glm::dvec3 crossing(const glm::dvec3& a, const glm::dvec3& b, double heightA, double heightB) {
    return a + heightA / (heightA - heightB) * (b - a);
}

/// Cuts off what of the segment is below 0; false if nothing is left. `land` puts a point there
/// exactly: what rounding leaves is magnified with the distance over the light's size.
template <class Height, class Land>
bool cut(glm::dvec3& a, glm::dvec3& b, const Height& height, const Land& land) {
    const double heightA = height(a), heightB = height(b);
    if (heightA < 0.0 && heightB < 0.0) return false;
    if (heightA < 0.0 || heightB < 0.0) {
        glm::dvec3& end = heightA < 0.0 ? a : b;
        end = crossing(a, b, heightA, heightB);
        land(end);
    }
    return true;
}

}  // namespace

CasterMesh::CasterMesh(const Geometry& geometry, const AreaLight& light) {
    std::vector<glm::vec3> places;
    const std::vector<std::uint32_t> place = placesOf(geometry.positions, places);
    const LightSpace space(light);
    vertices.reserve(places.size());
    for (const glm::vec3& p : places) vertices.push_back(space.point(glm::dvec3(p)));

    struct Use {
        std::uint32_t from, to, triangle;
        int corner;
        auto ends() const { return std::pair(std::min(from, to), std::max(from, to)); }
    };
    std::vector<Use> uses;
    uses.reserve(geometry.indices.size());
    triangles.reserve(geometry.triangleCount());
    for (std::size_t i = 0; i + 2 < geometry.indices.size(); i += 3) {
        const Triangle t = {place[geometry.indices[i]], place[geometry.indices[i + 1]],
                            place[geometry.indices[i + 2]]};
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        for (int k = 0; k < 3; ++k)
            uses.push_back({t[k], t[(k + 1) % 3], static_cast<std::uint32_t>(triangles.size()), k});
        triangles.push_back(t);
    }
    // What comes first of one edge's uses makes no difference.
    tbb::parallel_sort(uses, [](const Use& a, const Use& b) { return a.ends() < b.ends(); });
    edgesOf.resize(triangles.size());
    for (const Use& use : uses) {
        const auto [lower, higher] = use.ends();
        if (edges.empty() || edges.back()[0] != lower || edges.back()[1] != higher)
            edges.push_back({lower, higher});
        edgesOf[use.triangle][use.corner] = {static_cast<std::uint32_t>(edges.size() - 1),
                                             use.from == lower ? 1 : -1};
    }
}

double CasterMesh::side(std::uint32_t triangle, const glm::dvec3& p) const {
    const auto& [a, b, c] = triangles[triangle];
    const glm::dvec3 corner = vertices[a];
    return glm::dot(glm::cross(vertices[b] - corner, vertices[c] - corner), p - corner);
}

Outline::Outline(const CasterMesh& mesh, const glm::dvec2& halfLight)
    : mesh_(mesh),
      halfLight_(halfLight),
      counts_(mesh.edges.size(), 0),
      isTouched_(mesh.edges.size(), 0) {}

void Outline::touch(std::uint32_t edge, int count) {
    counts_[edge] += count;
    if (isTouched_[edge]) return;
    isTouched_[edge] = 1;
    touched_.push_back(edge);
}

void Outline::addTriangle(std::uint32_t triangle, int count) {
    for (const auto& [edge, direction] : mesh_.edgesOf[triangle]) touch(edge, count * direction);
}

void Outline::prepare(const Bounds& points, std::span<const std::uint32_t> triangles) {
    for (const std::uint32_t edge : touched_) {
        counts_[edge] = 0;
        isTouched_[edge] = 0;
    }
    touched_.clear();
    undecided_.clear();
    const glm::dvec3 centre = points.centre(), half = 0.5 * (points.hi - points.lo);
    const double lowestZ = kLightMargin * points.hi.z;
    const double highestZ = points.lo.z * (1.0 - kPointMargin);
    for (const std::uint32_t triangle : triangles) {
        const auto& [ia, ib, ic] = mesh_.triangles[triangle];
        const glm::dvec3 &a = mesh_.vertices[ia], &b = mesh_.vertices[ib], &c = mesh_.vertices[ic];
        const auto [nearest, farthest] = std::minmax({a.z, b.z, c.z});
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double side = glm::dot(normal, centre - a);
        const double spread = glm::dot(glm::abs(normal), half);
        // A triangle that some point's range of heights cuts is left to that point.
        if (nearest <= lowestZ || farthest >= highestZ || !(std::abs(side) > spread))
            undecided_.push_back(triangle);
        else
            addTriangle(triangle, side > 0.0 ? 1 : -1);
    }
    std::erase_if(touched_, [&](std::uint32_t edge) {
        if (counts_[edge] != 0) return false;
        isTouched_[edge] = 0;
        return true;
    });
    base_ = touched_.size();
}

Outline::Projected Outline::projected(const glm::dvec3& vertex) const {
    // From the point through the vertex to z = 0, in units of the light's sides from its corner.
    const double height = point_.z - vertex.z;
    const glm::dvec2 across(vertex.x - point_.x, vertex.y - point_.y);
    const glm::dvec2 corner(point_.x + halfLight_.x, point_.y + halfLight_.y);
    const glm::dvec2 onLight = (corner * height + across * point_.z) / (2.0 * halfLight_);
    return {onLight, height};
}

void Outline::project(const glm::dvec3& point, UnionSweep& sweep) {
    point_ = point;
    lowest_ = kPointMargin * point.z;
    highest_ = (1.0 - kLightMargin) * point.z;
    sweep.clear();
    turns_.clear();
    for (const std::uint32_t triangle : undecided_) {
        const double side = mesh_.side(triangle, point);
        const int turn = (side > 0.0) - (side < 0.0);
        turns_.push_back(turn);
        if (turn == 0) continue;
        addTriangle(triangle, turn);
        addCuts(triangle, turn, sweep);
    }
    for (const std::uint32_t edge : touched_)
        if (counts_[edge] != 0) addEdge(edge, counts_[edge], sweep);

    for (std::size_t i = 0; i < undecided_.size(); ++i)
        if (turns_[i] != 0) addTriangle(undecided_[i], -turns_[i]);
    for (std::size_t i = base_; i < touched_.size(); ++i) isTouched_[touched_[i]] = 0;
    touched_.resize(base_);
}

void Outline::addEdge(std::uint32_t edge, int count, UnionSweep& sweep) const {
    const auto& [from, to] = mesh_.edges[edge];
    Projected a = projected(mesh_.vertices[from]), b = projected(mesh_.vertices[to]);
    const auto aboveLowest = [&](const Projected& p) { return p.z - lowest_; };
    const auto belowHighest = [&](const Projected& p) { return highest_ - p.z; };
    if (cut(a, b, aboveLowest, [&](Projected& p) { p.z = lowest_; }) &&
        cut(a, b, belowHighest, [&](Projected& p) { p.z = highest_; }))
        addSegment(a, b, count, sweep);
}

void Outline::addCuts(std::uint32_t triangle, int count, UnionSweep& sweep) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const auto [nearest, farthest] =
        std::minmax({mesh_.vertices[a].z, mesh_.vertices[b].z, mesh_.vertices[c].z});
    if (point_.z - farthest <= lowest_) addCut(triangle, count, lowest_, sweep);
    if (point_.z - nearest >= highest_) addCut(triangle, -count, highest_, sweep);
}

void Outline::addCut(std::uint32_t triangle, int count, double height, UnionSweep& sweep) const {
    // `count` is that of the part above: its outline runs along the plane from where the triangle's
    // leaves the part to where it comes back.
    Projected leaves, comesBack;
    bool isCut = false;
    for (const auto& [edge, direction] : mesh_.edgesOf[triangle]) {
        const auto& [from, to] = mesh_.edges[edge];
        const Projected a = projected(mesh_.vertices[from]), b = projected(mesh_.vertices[to]);
        const double heightA = a.z - height, heightB = b.z - height;
        if ((heightA < 0.0) == (heightB < 0.0)) continue;
        isCut = true;
        const bool upwards = (heightB >= 0.0) == (direction > 0);
        (upwards ? comesBack : leaves) = crossing(a, b, heightA, heightB);
    }
    if (isCut) addSegment(leaves, comesBack, count, sweep);
}

void Outline::addSegment(Projected a, Projected b, int count, UnionSweep& sweep) const {
    const auto aboveLower = [](const Projected& p) { return p.y; };
    const auto belowUpper = [](const Projected& p) { return p.z - p.y; };
    const auto leftOfRight = [](const Projected& p) { return p.z - p.x; };
    // Counted from the left, what is right of the light does not matter. What is left of it does,
    // but not by how far.
    if (!cut(a, b, aboveLower, [](Projected& p) { p.y = 0.0; }) ||
        !cut(a, b, belowUpper, [](Projected& p) { p.y = p.z; }) ||
        !cut(a, b, leftOfRight, [](Projected& p) { p.x = p.z; }))
        return;
    const auto add = [&](const Projected& p, const Projected& q) {
        // Divided after cutting: within the square but for rounding.
        const auto unit = [](double x, double w) { return std::clamp(x / w, 0.0, 1.0); };
        sweep.add(unit(p.x, p.z), unit(p.y, p.z), unit(q.x, q.z), unit(q.y, q.z), -count);
    };
    if ((a.x < 0.0) == (b.x < 0.0)) {
        add(a, b);
        return;
    }
    Projected entry = crossing(a, b, a.x, b.x);
    entry.x = 0.0;
    add(a, entry);
    add(entry, b);
}

}  // namespace penumbra
