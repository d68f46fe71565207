// Martin Newell's teapot (University of Utah, 1975) from its Bezier patches. Rim, body, lid and
// bottom are bodies of revolution whose quarter circles have the control ratio 0.56; handle and
// spout are given by one half, mirrored.
#include <array>
#include <utility>

#include "scenes/assets/asset.hpp"

namespace penumbra::assets {
namespace {

using Patch = std::array<std::array<glm::vec3, 4>, 4>;  ///< [v][u], z up, as Newell measured it
constexpr int kSteps = 20;                              ///< quads along each side of a patch

glm::vec3 bezier(const std::array<glm::vec3, 4>& p, float t) {
    const float s = 1.0f - t;
    return s * s * s * p[0] + 3.0f * s * s * t * p[1] + 3.0f * s * t * t * p[2] + t * t * t * p[3];
}

glm::vec3 evaluate(const Patch& patch, float u, float v) {
    return bezier(
        {bezier(patch[0], u), bezier(patch[1], u), bezier(patch[2], u), bezier(patch[3], u)}, v);
}

/// Four (radius, height) control points each.
constexpr std::array<std::array<glm::vec2, 4>, 6> kRevolved{{
    {{{1.4f, 2.4f}, {1.3375f, 2.53125f}, {1.4375f, 2.53125f}, {1.5f, 2.4f}}},  // rim
    {{{1.5f, 2.4f}, {1.75f, 1.875f}, {2.0f, 1.35f}, {2.0f, 0.9f}}},            // body
    {{{2.0f, 0.9f}, {2.0f, 0.45f}, {1.5f, 0.225f}, {1.5f, 0.15f}}},
    {{{0.0f, 3.15f}, {0.8f, 3.15f}, {0.0f, 2.85f}, {0.2f, 2.7f}}},    // knob
    {{{0.2f, 2.7f}, {0.4f, 2.55f}, {1.3f, 2.55f}, {1.3f, 2.4f}}},     // lid
    {{{1.5f, 0.15f}, {1.5f, 0.075f}, {1.425f, 0.0f}, {0.0f, 0.0f}}},  // bottom
}};

/// Per curve of four points: the two (x, z) at its ends and half the width in y between them.
struct Section {
    glm::vec2 from, to;
    float halfWidth;
};
constexpr std::array<std::array<Section, 4>, 4> kSwept{{
    {{{{-1.6f, 2.025f}, {-1.5f, 2.25f}, 0.3f},  // handle, upper half
      {{-2.3f, 2.025f}, {-2.5f, 2.25f}, 0.3f},
      {{-2.7f, 2.025f}, {-3.0f, 2.25f}, 0.3f},
      {{-2.7f, 1.8f}, {-3.0f, 1.8f}, 0.3f}}},
    {{{{-2.7f, 1.8f}, {-3.0f, 1.8f}, 0.3f},  // handle, lower half
      {{-2.7f, 1.575f}, {-3.0f, 1.35f}, 0.3f},
      {{-2.5f, 1.125f}, {-2.65f, 0.9375f}, 0.3f},
      {{-2.0f, 0.9f}, {-1.9f, 0.6f}, 0.3f}}},
    {{{{1.7f, 1.425f}, {1.7f, 0.6f}, 0.66f},  // spout
      {{2.6f, 1.425f}, {3.1f, 0.825f}, 0.66f},
      {{2.3f, 2.1f}, {2.4f, 2.025f}, 0.25f},
      {{2.7f, 2.4f}, {3.3f, 2.4f}, 0.25f}}},
    {{{{2.7f, 2.4f}, {3.3f, 2.4f}, 0.25f},  // spout, lip
      {{2.8f, 2.475f}, {3.525f, 2.49375f}, 0.25f},
      {{2.9f, 2.475f}, {3.45f, 2.5125f}, 0.15f},
      {{2.8f, 2.4f}, {3.2f, 2.4f}, 0.15f}}},
}};

void addPatch(Shape& shape, const Patch& patch) {
    const auto base = static_cast<std::uint32_t>(shape.positions.size());
    constexpr std::uint32_t kRow = kSteps + 1;
    for (int j = 0; j <= kSteps; ++j) {
        for (int i = 0; i <= kSteps; ++i) {
            const glm::vec3 p =
                evaluate(patch, static_cast<float>(i) / kSteps, static_cast<float>(j) / kSteps);
            shape.addVertex({p.x, p.z, -p.y});
        }
    }
    for (std::uint32_t j = 0; j < kSteps; ++j) {
        for (std::uint32_t i = 0; i < kSteps; ++i) {
            const std::uint32_t a = base + j * kRow + i;
            shape.addQuad(a, a + kRow, a + kRow + 1, a + 1);
        }
    }
}

/// Patches meet in equal points; shared vertices let the shading run on across the seams.
Shape welded(const Shape& shape) {
    Shape result;
    std::vector<std::uint32_t> target;
    for (const glm::vec3& position : shape.positions) {
        std::uint32_t found = 0;
        while (found < result.positions.size() &&
               glm::distance(result.positions[found], position) > 1e-4f) {
            ++found;
        }
        if (found == result.positions.size()) result.addVertex(position);
        target.push_back(found);
    }
    for (std::size_t i = 0; i < shape.indices.size(); i += 3) {
        const std::uint32_t a = target[shape.indices[i]], b = target[shape.indices[i + 1]];
        const std::uint32_t c = target[shape.indices[i + 2]];
        // A patch that ends in a pole has a row of equal points there.
        if (a != b && b != c && c != a) result.addTriangle(a, b, c);
    }
    return result;
}

Patch revolvedPatch(const std::array<glm::vec2, 4>& profile, int quarter) {
    constexpr float kRatio = 0.56f;
    const glm::vec2 axes[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const glm::vec2 a = axes[quarter], b = axes[(quarter + 1) % 4];
    const std::array<glm::vec2, 4> arc{a, a + kRatio * b, kRatio * a + b, b};
    Patch patch;
    for (std::size_t v = 0; v < 4; ++v) {
        for (std::size_t u = 0; u < 4; ++u) {
            patch[v][u] = glm::vec3(profile[v].x * arc[u], profile[v].y);
        }
    }
    return patch;
}

Patch sweptPatch(const std::array<Section, 4>& sections, bool mirrored) {
    Patch patch;
    for (std::size_t v = 0; v < 4; ++v) {
        const Section& s = sections[v];
        const float y = mirrored ? -s.halfWidth : s.halfWidth;
        patch[v] = {glm::vec3(s.from.x, 0.0f, s.from.y), glm::vec3(s.from.x, y, s.from.y),
                    glm::vec3(s.to.x, y, s.to.y), glm::vec3(s.to.x, 0.0f, s.to.y)};
        if (mirrored) std::swap(patch[v][0], patch[v][3]), std::swap(patch[v][1], patch[v][2]);
    }
    return patch;
}

void teapot(Asset& asset) {
    asset.addGround(6.0f, 6.0f);
    const int glaze =
        asset.addMaterial({.name = "glaze", .color = {0.25f, 0.5f, 0.6f}, .doubleSided = true});
    Shape body, lid, handle, spout;
    for (int quarter = 0; quarter < 4; ++quarter) {
        for (const std::size_t part : {0u, 1u, 2u, 5u}) {
            addPatch(body, revolvedPatch(kRevolved[part], quarter));
        }
        for (const std::size_t part : {3u, 4u}) {
            addPatch(lid, revolvedPatch(kRevolved[part], quarter));
        }
    }
    for (const bool mirrored : {false, true}) {
        addPatch(handle, sweptPatch(kSwept[0], mirrored));
        addPatch(handle, sweptPatch(kSwept[1], mirrored));
        addPatch(spout, sweptPatch(kSwept[2], mirrored));
        addPatch(spout, sweptPatch(kSwept[3], mirrored));
    }
    const int root = asset.addNode({.name = "teapot", .scale = glm::vec3(0.35f)});
    const auto addPart = [&](const char* name, const Shape& shape) {
        asset.addNode({.name = name,
                       .mesh = asset.addMesh(name, welded(shape), glaze, 50.0f),
                       .parent = root});
    };
    addPart("body", body);
    addPart("lid", lid);
    addPart("handle", handle);
    addPart("spout", spout);
}

const Register kTeapot{"teapot", teapot};

}  // namespace
}  // namespace penumbra::assets
