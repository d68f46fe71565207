#include "core/analysis/convexity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

namespace penumbra {
namespace {

struct Face {
    std::array<glm::vec3, 3> corners;
    glm::dvec3 normal;  ///< unit
    double heightM;     ///< dot(normal, point) of its plane
};

/// One side of a face: ends in the order of their coordinates, so that neighbours have the same.
struct Side {
    glm::vec3 a, b, opposite;
    std::uint32_t face;
};

bool before(const glm::vec3& p, const glm::vec3& q) {
    return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
}

/// Solid angle of a face seen from `eye` (Van Oosterom and Strackee 1983), not signed.
double solidAngle(const Face& face, const glm::dvec3& eye) {
    const glm::dvec3 a = glm::dvec3(face.corners[0]) - eye, b = glm::dvec3(face.corners[1]) - eye,
                     c = glm::dvec3(face.corners[2]) - eye;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = std::abs(glm::dot(a, glm::cross(b, c)));
    return 2.0 * std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la +
                                        glm::dot(c, a) * lb);
}

bool inOnePlane(const std::vector<Face>& faces, double toleranceM) {
    const Face& first = faces.front();
    return std::ranges::all_of(faces, [&](const Face& face) {
        return std::ranges::all_of(face.corners, [&](const glm::vec3& p) {
            return std::abs(glm::dot(first.normal, glm::dvec3(p)) - first.heightM) <= toleranceM;
        });
    });
}

/// Seen from a point inside, faces that turn their backs to it everywhere, meet in pairs along
/// convex edges and cover every direction once are the surface of a convex solid (Tietze and
/// Nakajima: closed, connected and locally convex is convex; covering every direction once excludes
/// surfaces that are wound twice around the point).
bool boundConvexSolid(std::vector<Face>& faces, double toleranceM) {
    glm::dvec3 inside(0.0);
    for (const Face& face : faces)
        for (const glm::vec3& p : face.corners)
            inside += glm::dvec3(p) / (3.0 * static_cast<double>(faces.size()));
    double covered = 0.0;
    std::vector<Side> sides;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        Face& face = faces[f];
        double above = face.heightM - glm::dot(face.normal, inside);
        if (above < 0.0) face.normal = -face.normal, face.heightM = -face.heightM, above = -above;
        if (above <= toleranceM) return false;
        covered += solidAngle(face, inside);
        for (std::size_t k = 0; k < 3; ++k) {
            glm::vec3 a = face.corners[k], b = face.corners[(k + 1) % 3];
            if (before(b, a)) std::swap(a, b);
            sides.push_back({a, b, face.corners[(k + 2) % 3], f});
        }
    }
    std::ranges::sort(sides, [](const Side& l, const Side& r) {
        return l.a != r.a ? before(l.a, r.a) : before(l.b, r.b);
    });
    for (std::size_t i = 0; i < sides.size(); i += 2) {
        const auto same = [&](std::size_t k) {
            return k < sides.size() && sides[k].a == sides[i].a && sides[k].b == sides[i].b;
        };
        if (!same(i + 1) || same(i + 2)) return false;
        const auto below = [&](const glm::vec3& p, const Face& face) {
            return glm::dot(face.normal, glm::dvec3(p)) - face.heightM <= toleranceM;
        };
        if (!below(sides[i].opposite, faces[sides[i + 1].face]) ||
            !below(sides[i + 1].opposite, faces[sides[i].face]))
            return false;
    }
    // Twice around would be twice as much; rounding is far from that.
    return std::abs(covered - 4.0 * std::numbers::pi) < 0.1;
}

}  // namespace

bool isOneCaster(const Geometry& geometry, std::span<const std::uint32_t> triangles) {
    std::vector<Face> faces;
    double extentM = 0.0;
    for (const std::uint32_t t : triangles) {
        Face face;
        for (std::size_t k = 0; k < 3; ++k) {
            // -0 and 0 are one place.
            face.corners[k] = geometry.positions[geometry.indices[3 * t + k]] + 0.0f;
            const glm::vec3 far = glm::abs(face.corners[k]);
            extentM = std::max({extentM, double{far.x}, double{far.y}, double{far.z}});
        }
        const glm::dvec3 a(face.corners[0]);
        const glm::dvec3 across =
            glm::cross(glm::dvec3(face.corners[1]) - a, glm::dvec3(face.corners[2]) - a);
        const double length = glm::length(across);
        if (!(length > 0.0)) continue;  // covers nothing
        face.normal = across / length;
        face.heightM = glm::dot(face.normal, a);
        faces.push_back(face);
    }
    if (faces.empty()) return true;
    const double toleranceM = 4.0 * std::numeric_limits<float>::epsilon() * extentM;
    return inOnePlane(faces, toleranceM) || boundConvexSolid(faces, toleranceM);
}

}  // namespace penumbra
