#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra::assets {

/// Triangles over shared positions, counter-clockwise seen from outside. The bodies made here are
/// watertight by construction: neighbouring triangles share their vertices, and seams and poles are
/// one vertex each. Normals come later (asset.hpp), so that creases do not open a surface.
struct Shape {
    std::vector<glm::vec3> positions;    ///< metres
    std::vector<glm::vec2> uvs;          ///< empty, or one per position
    std::vector<std::uint32_t> indices;  ///< three per triangle

    std::size_t triangleCount() const { return indices.size() / 3; }
    std::uint32_t addVertex(glm::vec3 position);
    void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// Corners in counter-clockwise order seen from the front.
    void addQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);
    /// Adds a copy of `other` under `transform`; a mirroring transform keeps the outside outside.
    void append(const Shape& other, const glm::mat4& transform = glm::mat4(1.0f));
};

/// What closes a loft where its rings end.
enum class Caps {
    none,    ///< nothing: an open sheet
    flat,    ///< a fan about the centroid of the first and of the last ring
    joined,  ///< the last ring is followed by the first
};

/// A skin over rings of equally many points. Seen along the path from ring to ring, the points of a
/// ring run clockwise.
Shape loft(const std::vector<std::vector<glm::vec3>>& rings, Caps caps);

/// A surface of revolution about Y: `profile` is (radius, height) from bottom to top. A first or
/// last point of radius 0 is a pole; other ends are closed by flat caps. `radiusScale`, when given,
/// modulates the radius by (profile index, angle): flutes, for example.
Shape lathe(const std::vector<glm::vec2>& profile, int sectors,
            const std::function<float(std::size_t, float)>& radiusScale = {});

/// A tube along `path` with one radius per point, closed by flat caps.
Shape tube(const std::vector<glm::vec3>& path, const std::vector<float>& radiiM, int sides);
/// A straight tube.
Shape rod(glm::vec3 from, glm::vec3 to, float radiusM, int sides);
/// A ring in the xz plane.
Shape torus(float majorRadiusM, float minorRadiusM, int segments, int sides);

Shape box(glm::vec3 lo, glm::vec3 hi);
/// A convex outline in the xy plane, counter-clockwise seen from +z, given the thickness `depthM`
/// centred on z = 0.
Shape prism(const std::vector<glm::vec2>& outline, float depthM);

/// An icosahedron subdivided `level` times (20 * 4^level triangles), pushed out along each unit
/// direction to the distance `radiusM(direction)`.
Shape blob(int level, const std::function<float(glm::vec3)>& radiusM);
Shape sphere(float radiusM, int level);

/// A horizontal rectangle, centred, facing up; two triangles.
Shape plate(float sizeXM, float sizeZM);

/// A shape with a normal per vertex, as glTF stores it.
struct ShadedShape {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> indices;
};
/// Every corner's normal is the mean, by area, of the faces at its position that lie within
/// `creaseDeg` of its own face. Vertices are duplicated only where normals differ.
ShadedShape shade(const Shape& shape, float creaseDeg);

/// Translation, then rotation by `degrees` about `axis`.
glm::mat4 placed(glm::vec3 translation, float degrees = 0.0f, glm::vec3 axis = {0, 1, 0});

}  // namespace penumbra::assets
