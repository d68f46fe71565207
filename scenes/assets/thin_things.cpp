// Thin casters: wings without thickness and wires thinner than a shadow-map texel.
#include <cmath>
#include <numbers>

#include "scenes/assets/asset.hpp"

namespace penumbra::assets {
namespace {

/// Closed Catmull-Rom curve through `points`, `perSpan` samples each.
std::vector<glm::vec2> smoothOutline(const std::vector<glm::vec2>& points, int perSpan) {
    std::vector<glm::vec2> curve;
    const std::size_t n = points.size();
    for (std::size_t i = 0; i < n; ++i) {
        const glm::vec2 a = points[(i + n - 1) % n], b = points[i];
        const glm::vec2 c = points[(i + 1) % n], d = points[(i + 2) % n];
        for (int s = 0; s < perSpan; ++s) {
            const float t = static_cast<float>(s) / static_cast<float>(perSpan);
            curve.push_back(0.5f *
                            (2.0f * b + (c - a) * t + (2.0f * a - 5.0f * b + 4.0f * c - d) * t * t +
                             (3.0f * b - a - 3.0f * c + d) * t * t * t));
        }
    }
    return curve;
}

/// A sheet spanned between a point inside and the outline around it, both in (x, z), counter-
/// clockwise seen from above, bent upwards with the distance from the body.
void addWing(Shape& wing, glm::vec2 inner, const std::vector<glm::vec2>& outline, float heightM) {
    constexpr int kRings = 6;
    const auto bent = [heightM](glm::vec2 p) {
        return glm::vec3(p.x, heightM + 0.35f * p.x + 0.25f * p.x * p.x, p.y);
    };
    const auto count = static_cast<std::uint32_t>(outline.size());
    const std::uint32_t centre = wing.addVertex(bent(inner));
    for (int r = 1; r <= kRings; ++r) {
        for (const glm::vec2& edge : outline) {
            wing.addVertex(bent(glm::mix(inner, edge, static_cast<float>(r) / kRings)));
        }
    }
    for (std::uint32_t p = 0; p < count; ++p) {
        const std::uint32_t a = centre + 1 + p, b = centre + 1 + (p + 1) % count;
        wing.addTriangle(centre, a, b);
        for (std::uint32_t r = 0; r + 1 < kRings; ++r) {
            wing.addQuad(a + r * count, a + (r + 1) * count, b + (r + 1) * count, b + r * count);
        }
    }
}

void butterfly(Asset& asset) {
    asset.addGround(6.0f, 6.0f);
    const int wingMaterial =
        asset.addMaterial({.name = "wing", .color = {0.85f, 0.4f, 0.05f}, .doubleSided = true});
    const int bodyMaterial = asset.addMaterial({.name = "body", .color = {0.12f, 0.09f, 0.07f}});

    Shape wing;  // the right side: x away from the body, the head towards -z
    addWing(wing, {0.4f, -0.35f},
            smoothOutline({{0.03f, -0.02f},
                           {0.5f, -0.02f},
                           {0.82f, -0.3f},
                           {0.98f, -0.72f},
                           {0.85f, -0.82f},
                           {0.4f, -0.58f},
                           {0.03f, -0.2f}},
                          6),
            0.03f);
    addWing(wing, {0.3f, 0.2f},
            smoothOutline({{0.03f, 0.16f},
                           {0.2f, 0.45f},
                           {0.33f, 0.72f},
                           {0.42f, 0.56f},
                           {0.64f, 0.4f},
                           {0.62f, 0.08f},
                           {0.35f, -0.06f},
                           {0.03f, -0.04f}},
                          6),
            -0.02f);
    const int wingMesh = asset.addMesh("wing", wing, wingMaterial);
    // Both wings are one mesh; the left one is mirrored, as modellers do.
    const glm::quat pose = glm::angleAxis(glm::radians(-14.0f), glm::vec3(1, 0, 0));
    const int root =
        asset.addNode({.name = "butterfly", .translation = {0.0f, 0.75f, 0.1f}, .rotation = pose});
    asset.addNode({.name = "right wing", .mesh = wingMesh, .parent = root});
    asset.addNode({.name = "left wing",
                   .mesh = wingMesh,
                   .parent = root,
                   .rotation = glm::angleAxis(glm::radians(-8.0f), glm::vec3(0, 0, 1)),
                   .scale = {-1.0f, 1.0f, 1.0f}});

    Shape body = tube({{0, 0, 0.5f},
                       {0, 0, 0.3f},
                       {0, 0, 0.05f},
                       {0, 0.01f, -0.12f},
                       {0, 0, -0.24f},
                       {0, 0, -0.27f},
                       {0, 0, -0.34f},
                       {0, 0, -0.38f}},
                      {0.008f, 0.03f, 0.032f, 0.05f, 0.03f, 0.022f, 0.035f, 0.012f}, 14);
    for (const float side : {-1.0f, 1.0f}) {
        body.append(tube({{side * 0.015f, 0.01f, -0.37f},
                          {side * 0.09f, 0.07f, -0.52f},
                          {side * 0.19f, 0.1f, -0.66f},
                          {side * 0.26f, 0.1f, -0.74f}},
                         {0.004f, 0.003f, 0.003f, 0.009f}, 6));
    }
    asset.addNode(
        {.name = "body", .mesh = asset.addMesh("body", body, bodyMaterial, 60.0f), .parent = root});
}

void antennas(Asset& asset) {
    asset.addGround(8.0f, 8.0f);
    const int steel = asset.addMaterial({.name = "steel", .color = {0.45f, 0.47f, 0.5f}});
    const int copper = asset.addMaterial({.name = "copper", .color = {0.7f, 0.35f, 0.15f}});
    constexpr float kWireRadiusM = 0.00075f;
    constexpr int kSides = 5;

    // Short pieces: boxes around metre-long slanting slivers would overlap and slow every ray.
    const auto wire = [&](const glm::vec3& from, const glm::vec3& to) {
        constexpr float kPieceM = 0.06f;
        const int pieces = static_cast<int>(std::ceil(glm::distance(from, to) / kPieceM));
        std::vector<glm::vec3> path;
        for (int i = 0; i <= pieces; ++i)
            path.push_back(glm::mix(from, to, static_cast<float>(i) / static_cast<float>(pieces)));
        return tube(path, std::vector<float>(path.size(), kWireRadiusM), kSides);
    };

    Shape masts, wires;
    masts.append(rod({-0.9f, 0.0f, -0.3f}, {-0.9f, 1.5f, -0.3f}, 0.012f, 12));
    masts.append(rod({1.1f, 0.0f, 0.4f}, {1.1f, 1.1f, 0.4f}, 0.012f, 12));
    // Two television antennas: a boom with elements that shorten towards its front.
    const auto addYagi = [&](glm::vec3 centre, float turnDeg, int elements) {
        const glm::mat4 frame = placed(centre, turnDeg);
        Shape boom = rod({-0.55f, 0, 0}, {0.55f, 0, 0}, 0.005f, 8);
        masts.append(boom, frame);
        for (int i = 0; i < elements; ++i) {
            const float t = static_cast<float>(i) / static_cast<float>(elements - 1);
            const float x = glm::mix(-0.53f, 0.53f, t), half = glm::mix(0.48f, 0.22f, t);
            wires.append(wire({x, 0, -half}, {x, 0, half}), frame);
        }
    };
    addYagi({-0.9f, 1.45f, -0.3f}, 20.0f, 11);
    addYagi({-0.9f, 0.95f, -0.3f}, -40.0f, 9);
    // Guys from both mast heads.
    for (int i = 0; i < 4; ++i) {
        const float angle = (0.25f + 0.5f * static_cast<float>(i)) * std::numbers::pi_v<float>;
        const glm::vec3 foot(0.9f * std::cos(angle), 0.0f, 0.9f * std::sin(angle));
        wires.append(wire({-0.9f, 1.2f, -0.3f}, glm::vec3(-0.9f, 0, -0.3f) + foot));
        wires.append(wire({1.1f, 1.0f, 0.4f}, glm::vec3(1.1f, 0, 0.4f) + 0.7f * foot));
    }
    // A wire aerial sagging between the masts, five strands side by side.
    for (int strand = 0; strand < 5; ++strand) {
        const float shift = 0.09f * static_cast<float>(strand - 2);
        std::vector<glm::vec3> path;
        for (int i = 0; i <= 16; ++i) {
            const float t = static_cast<float>(i) / 16.0f;
            glm::vec3 point =
                glm::mix(glm::vec3(-0.9f, 0.75f, -0.3f), glm::vec3(1.1f, 0.75f, 0.4f), t);
            point += glm::vec3(-0.33f, 0.0f, 0.94f) * shift;
            point.y -= 0.8f * t * (1.0f - t);
            path.push_back(point);
        }
        wires.append(tube(path, std::vector<float>(path.size(), kWireRadiusM), kSides));
    }
    // Whips standing on the ground, bent by the wind.
    for (int i = 0; i < 7; ++i) {
        const float x = -1.5f + 0.5f * static_cast<float>(i);
        std::vector<glm::vec3> path;
        for (int s = 0; s <= 10; ++s) {
            const float t = static_cast<float>(s) / 10.0f;
            path.emplace_back(x + 0.35f * t * t, 0.9f * t, 1.15f + 0.1f * t * t);
        }
        wires.append(tube(path, std::vector<float>(path.size(), 0.001f), kSides));
    }
    asset.place("masts", masts, steel);
    asset.place("wires", wires, copper, 80.0f);
}

const Register kButterfly{"butterfly", butterfly};
const Register kAntennas{"antennas", antennas};

}  // namespace
}  // namespace penumbra::assets
