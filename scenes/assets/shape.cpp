#include "scenes/assets/shape.hpp"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <map>
#include <numbers>
#include <utility>

namespace penumbra::assets {
namespace {

constexpr float kTwoPi = 2.0f * std::numbers::pi_v<float>;

glm::vec3 centroid(const std::vector<glm::vec3>& points) {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& point : points) sum += point;
    return sum / static_cast<float>(points.size());
}

}  // namespace

std::uint32_t Shape::addVertex(glm::vec3 position) {
    positions.push_back(position);
    return static_cast<std::uint32_t>(positions.size() - 1);
}

void Shape::addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    indices.insert(indices.end(), {a, b, c});
}

void Shape::addQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    addTriangle(a, b, c);
    addTriangle(a, c, d);
}

void Shape::append(const Shape& other, const glm::mat4& transform) {
    const auto base = static_cast<std::uint32_t>(positions.size());
    for (const glm::vec3& position : other.positions) {
        positions.emplace_back(transform * glm::vec4(position, 1.0f));
    }
    uvs.insert(uvs.end(), other.uvs.begin(), other.uvs.end());
    const bool mirrored = glm::determinant(glm::mat3(transform)) < 0.0f;
    for (std::size_t i = 0; i < other.indices.size(); i += 3) {
        const std::uint32_t a = base + other.indices[i];
        const std::uint32_t b = base + other.indices[i + 1];
        const std::uint32_t c = base + other.indices[i + 2];
        mirrored ? addTriangle(a, c, b) : addTriangle(a, b, c);
    }
}

Shape loft(const std::vector<std::vector<glm::vec3>>& rings, Caps caps) {
    Shape shape;
    const std::size_t count = rings.front().size();
    for (const auto& ring : rings) {
        for (const glm::vec3& point : ring) shape.addVertex(point);
    }
    const auto at = [&](std::size_t ring, std::size_t point) {
        return static_cast<std::uint32_t>(ring % rings.size() * count + point % count);
    };
    const std::size_t spans = caps == Caps::joined ? rings.size() : rings.size() - 1;
    for (std::size_t r = 0; r < spans; ++r) {
        for (std::size_t p = 0; p < count; ++p) {
            shape.addQuad(at(r, p), at(r + 1, p), at(r + 1, p + 1), at(r, p + 1));
        }
    }
    if (caps == Caps::flat) {
        const std::size_t last = rings.size() - 1;
        const std::uint32_t start = shape.addVertex(centroid(rings.front()));
        const std::uint32_t end = shape.addVertex(centroid(rings.back()));
        for (std::size_t p = 0; p < count; ++p) {
            shape.addTriangle(start, at(0, p), at(0, p + 1));
            shape.addTriangle(end, at(last, p + 1), at(last, p));
        }
    }
    return shape;
}

Shape lathe(const std::vector<glm::vec2>& profile, int sectors,
            const std::function<float(std::size_t, float)>& radiusScale) {
    std::vector<std::vector<glm::vec3>> rings;
    for (std::size_t i = 0; i < profile.size(); ++i) {
        if (profile[i].x <= 0.0f) continue;
        std::vector<glm::vec3>& ring = rings.emplace_back();
        for (int s = 0; s < sectors; ++s) {
            const float angle = kTwoPi * static_cast<float>(s) / static_cast<float>(sectors);
            const float radius = profile[i].x * (radiusScale ? radiusScale(i, angle) : 1.0f);
            ring.emplace_back(radius * std::cos(angle), profile[i].y, radius * std::sin(angle));
        }
    }
    Shape shape = loft(rings, Caps::flat);
    // The caps' centres become the poles; they are the last two vertices.
    const std::size_t count = shape.positions.size();
    shape.positions[count - 2] = {0.0f, profile.front().y, 0.0f};
    shape.positions[count - 1] = {0.0f, profile.back().y, 0.0f};
    return shape;
}

Shape tube(const std::vector<glm::vec3>& path, const std::vector<float>& radiiM, int sides) {
    std::vector<std::vector<glm::vec3>> rings;
    glm::vec3 normal(0.0f);
    for (std::size_t i = 0; i < path.size(); ++i) {
        const glm::vec3 along =
            glm::normalize(path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]);
        // Parallel transport keeps the rings from twisting against each other.
        if (i == 0) normal = std::abs(along.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
        normal = glm::normalize(normal - glm::dot(normal, along) * along);
        const glm::vec3 binormal = glm::cross(normal, along);
        std::vector<glm::vec3>& ring = rings.emplace_back();
        for (int s = 0; s < sides; ++s) {
            const float angle = kTwoPi * static_cast<float>(s) / static_cast<float>(sides);
            ring.push_back(path[i] +
                           radiiM[i] * (std::cos(angle) * normal + std::sin(angle) * binormal));
        }
    }
    return loft(rings, Caps::flat);
}

Shape rod(glm::vec3 from, glm::vec3 to, float radiusM, int sides) {
    return tube({from, to}, {radiusM, radiusM}, sides);
}

Shape torus(float majorRadiusM, float minorRadiusM, int segments, int sides) {
    std::vector<std::vector<glm::vec3>> rings;
    for (int i = 0; i < segments; ++i) {
        const float around = kTwoPi * static_cast<float>(i) / static_cast<float>(segments);
        const glm::vec3 outward(std::cos(around), 0.0f, std::sin(around));
        std::vector<glm::vec3>& ring = rings.emplace_back();
        for (int s = 0; s < sides; ++s) {
            const float angle = kTwoPi * static_cast<float>(s) / static_cast<float>(sides);
            ring.push_back(outward * (majorRadiusM + minorRadiusM * std::cos(angle)) +
                           glm::vec3(0.0f, minorRadiusM * std::sin(angle), 0.0f));
        }
    }
    for (auto& ring : rings) std::reverse(ring.begin(), ring.end());
    return loft(rings, Caps::joined);
}

Shape box(glm::vec3 lo, glm::vec3 hi) {
    Shape shape;
    for (unsigned corner = 0; corner < 8; ++corner) {
        shape.addVertex(
            {corner & 1u ? hi.x : lo.x, corner & 2u ? hi.y : lo.y, corner & 4u ? hi.z : lo.z});
    }
    shape.addQuad(0, 4, 6, 2);  // -x
    shape.addQuad(1, 3, 7, 5);  // +x
    shape.addQuad(0, 1, 5, 4);  // -y
    shape.addQuad(2, 6, 7, 3);  // +y
    shape.addQuad(0, 2, 3, 1);  // -z
    shape.addQuad(4, 5, 7, 6);  // +z
    return shape;
}

Shape prism(const std::vector<glm::vec2>& outline, float depthM) {
    std::vector<std::vector<glm::vec3>> rings(2);
    for (auto point = outline.rbegin(); point != outline.rend(); ++point) {
        rings[0].emplace_back(*point, -0.5f * depthM);
        rings[1].emplace_back(*point, 0.5f * depthM);
    }
    return loft(rings, Caps::flat);
}

Shape blob(int level, const std::function<float(glm::vec3)>& radiusM) {
    const float g = std::numbers::phi_v<float>;
    Shape shape;
    shape.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    shape.indices = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                     4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                     6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
    for (int l = 0; l < level; ++l) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> midpoints;
        const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
            const auto [entry, isNew] = midpoints.try_emplace(std::minmax(a, b), 0u);
            if (isNew) {
                entry->second = shape.addVertex(glm::normalize(glm::normalize(shape.positions[a]) +
                                                               glm::normalize(shape.positions[b])));
            }
            return entry->second;
        };
        const std::vector<std::uint32_t> coarse = std::exchange(shape.indices, {});
        for (std::size_t i = 0; i < coarse.size(); i += 3) {
            const std::uint32_t a = coarse[i], b = coarse[i + 1], c = coarse[i + 2];
            const std::uint32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
            shape.addTriangle(a, ab, ca);
            shape.addTriangle(b, bc, ab);
            shape.addTriangle(c, ca, bc);
            shape.addTriangle(ab, bc, ca);
        }
    }
    for (glm::vec3& position : shape.positions) {
        const glm::vec3 direction = glm::normalize(position);
        position = direction * radiusM(direction);
    }
    return shape;
}

Shape sphere(float radiusM, int level) {
    return blob(level, [radiusM](glm::vec3) { return radiusM; });
}

Shape plate(float sizeXM, float sizeZM) {
    const float x = 0.5f * sizeXM, z = 0.5f * sizeZM;
    Shape shape;
    shape.positions = {{-x, 0, z}, {x, 0, z}, {x, 0, -z}, {-x, 0, -z}};
    shape.addQuad(0, 1, 2, 3);
    return shape;
}

ShadedShape shade(const Shape& shape, float creaseDeg) {
    const std::size_t triangles = shape.triangleCount();
    std::vector<glm::vec3> faceNormals(triangles);  // twice the area long
    std::vector<std::vector<std::uint32_t>> facesAt(shape.positions.size());
    for (std::size_t t = 0; t < triangles; ++t) {
        const glm::vec3 a = shape.positions[shape.indices[3 * t]];
        faceNormals[t] = glm::cross(shape.positions[shape.indices[3 * t + 1]] - a,
                                    shape.positions[shape.indices[3 * t + 2]] - a);
        for (std::size_t k = 0; k < 3; ++k) {
            facesAt[shape.indices[3 * t + k]].push_back(static_cast<std::uint32_t>(t));
        }
    }
    const float minCosine = std::cos(glm::radians(creaseDeg));
    ShadedShape shaded;
    std::vector<std::vector<std::uint32_t>> copies(shape.positions.size());
    for (std::size_t corner = 0; corner < shape.indices.size(); ++corner) {
        const std::uint32_t vertex = shape.indices[corner];
        const glm::vec3 own = glm::normalize(faceNormals[corner / 3]);
        glm::vec3 sum(0.0f);
        for (const std::uint32_t face : facesAt[vertex]) {
            if (glm::dot(glm::normalize(faceNormals[face]), own) >= minCosine) {
                sum += faceNormals[face];
            }
        }
        const glm::vec3 normal = glm::normalize(sum);
        std::uint32_t index = static_cast<std::uint32_t>(shaded.positions.size());
        for (const std::uint32_t copy : copies[vertex]) {
            if (glm::dot(shaded.normals[copy], normal) > 0.99999f) index = copy;
        }
        if (index == shaded.positions.size()) {
            copies[vertex].push_back(index);
            shaded.positions.push_back(shape.positions[vertex]);
            shaded.normals.push_back(normal);
            if (!shape.uvs.empty()) shaded.uvs.push_back(shape.uvs[vertex]);
        }
        shaded.indices.push_back(index);
    }
    return shaded;
}

glm::mat4 placed(glm::vec3 translation, float degrees, glm::vec3 axis) {
    return glm::rotate(glm::translate(glm::mat4(1.0f), translation), glm::radians(degrees), axis);
}

}  // namespace penumbra::assets
