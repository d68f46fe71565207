// Two rows of fluted columns that carry round arches: about 200,000 triangles, the scene for
// methods whose cost grows with the geometry.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/assets/asset.hpp"

namespace penumbra::assets {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kSpacingM = 1.1f;    ///< between column axes
constexpr float kShaftTopM = 1.75f;  ///< where the arches spring
constexpr int kColumns = 5;          ///< per row
constexpr float kRowXM = 0.95f;      ///< the rows stand at -x and +x

/// Twenty flutes with flat fillets between them, as an Ionic shaft has; mouldings stay round.
Shape column() {
    constexpr int kFlutes = 20;
    constexpr int kSectors = 6 * kFlutes;
    std::vector<glm::vec2> profile{
        {0.2f, 0.0f},    {0.2f, 0.07f},   {0.185f, 0.07f},  {0.195f, 0.09f},  {0.195f, 0.11f},
        {0.175f, 0.13f}, {0.165f, 0.14f}, {0.175f, 0.155f}, {0.165f, 0.175f}, {0.15f, 0.18f}};
    const std::size_t firstFluted = profile.size();
    constexpr int kRows = 52;
    for (int i = 0; i <= kRows; ++i) {
        const float t = static_cast<float>(i) / kRows;
        // Entasis: the shaft swells a little before it tapers.
        const float radius = 0.14f - 0.022f * t * t;
        profile.emplace_back(radius, glm::mix(0.2f, kShaftTopM - 0.2f, t));
    }
    const std::size_t lastFluted = profile.size();
    const float y = kShaftTopM;
    profile.insert(profile.end(), {{0.125f, y - 0.18f},
                                   {0.135f, y - 0.17f},
                                   {0.125f, y - 0.155f},
                                   {0.13f, y - 0.13f},
                                   {0.155f, y - 0.09f},
                                   {0.185f, y - 0.07f},
                                   {0.2f, y - 0.06f},
                                   {0.2f, y}});
    return lathe(profile, kSectors, [=](std::size_t i, float angle) {
        if (i < firstFluted || i >= lastFluted) return 1.0f;
        const float ends = std::min({1.0f, 0.4f * static_cast<float>(i - firstFluted),
                                     0.4f * static_cast<float>(lastFluted - 1 - i)});
        const float flute = std::max(0.0f, std::sin(static_cast<float>(kFlutes) * angle));
        return 1.0f - 0.1f * ends * flute;
    });
}

/// A moulded half ring over a span along z: the cross-section, in (radius, x), swept through 180
/// degrees about the x axis.
Shape arch(float innerRadiusM, float outerRadiusM, int steps) {
    const float mid = 0.5f * (innerRadiusM + outerRadiusM), rise = outerRadiusM - innerRadiusM;
    const std::vector<glm::vec2> section{{innerRadiusM, -0.14f},
                                         {innerRadiusM, 0.14f},
                                         {innerRadiusM + 0.3f * rise, 0.14f},
                                         {innerRadiusM + 0.3f * rise, 0.155f},
                                         {mid, 0.155f},
                                         {mid, 0.17f},
                                         {outerRadiusM, 0.17f},
                                         {outerRadiusM, -0.17f},
                                         {mid, -0.17f},
                                         {mid, -0.155f},
                                         {innerRadiusM + 0.3f * rise, -0.155f},
                                         {innerRadiusM + 0.3f * rise, -0.14f}};
    std::vector<std::vector<glm::vec3>> rings;
    for (int i = 0; i <= steps; ++i) {
        const float angle = kPi * static_cast<float>(i) / static_cast<float>(steps);
        std::vector<glm::vec3>& ring = rings.emplace_back();
        for (const glm::vec2& point : section) {
            ring.emplace_back(point.y, point.x * std::sin(angle), point.x * std::cos(angle));
        }
    }
    return loft(rings, Caps::flat);
}

void arcade(Asset& asset) {
    asset.addGround(14.0f, 14.0f);
    const int stone = asset.addMaterial({.name = "stone", .color = {0.72f, 0.66f, 0.55f}});
    const int brick = asset.addMaterial({.name = "arch", .color = {0.68f, 0.5f, 0.38f}});

    const Shape oneColumn = column();
    const float half = 0.5f * kSpacingM;
    const Shape oneArch = arch(half - 0.16f, half - 0.01f, 160);
    const Shape plinth = box({-0.22f, 0.0f, -0.22f}, {0.22f, 0.08f, 0.22f});
    const Shape block = box({-0.21f, 0.0f, -0.21f}, {0.21f, 0.1f, 0.21f});
    Shape columns, arches;
    for (const float x : {-kRowXM, kRowXM}) {
        for (int i = 0; i < kColumns; ++i) {
            const float z = kSpacingM * (static_cast<float>(i) - 0.5f * (kColumns - 1));
            columns.append(oneColumn, placed({x, 0.08f, z}));
            columns.append(plinth, placed({x, 0.0f, z}));
            columns.append(block, placed({x, kShaftTopM + 0.08f, z}));
            if (i + 1 < kColumns) arches.append(oneArch, placed({x, kShaftTopM + 0.18f, z + half}));
        }
    }
    asset.place("columns", columns, stone);
    asset.place("arches", arches, brick);
}

const Register kArcade{"arcade", arcade};

}  // namespace
}  // namespace penumbra::assets
