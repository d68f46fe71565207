// Big lumpy bodies with large inner areas, after the second test scene of Arvo and Westerholm 2004.
#include <algorithm>
#include <cmath>

#include "scenes/assets/asset.hpp"
#include "scenes/assets/random.hpp"

namespace penumbra::assets {
namespace {

struct Puff {
    glm::vec3 centre;
    float radiusM;
};

/// The far side, seen from the origin, of the union of balls that all contain the origin or are
/// reached through one that does; the hull is star-shaped, so that it stays one closed body.
float reach(const std::vector<Puff>& puffs, glm::vec3 direction) {
    float farthest = 0.0f;
    for (const Puff& puff : puffs) {
        const float along = glm::dot(direction, puff.centre);
        const float squared =
            puff.radiusM * puff.radiusM - glm::dot(puff.centre, puff.centre) + along * along;
        if (squared > 0.0f) farthest = std::max(farthest, along + std::sqrt(squared));
    }
    return farthest;
}

Shape cloud(Random& random, float sizeM) {
    std::vector<Puff> puffs{{{0, 0, 0}, 0.38f * sizeM}};
    for (int i = 0; i < 9; ++i) {
        const float angle = 0.698f * static_cast<float>(i) + random.uniform(-0.25f, 0.25f);
        const float out = random.uniform(0.3f, 0.42f) * sizeM;
        puffs.push_back({{1.15f * out * std::cos(angle), random.uniform(-0.02f, 0.14f) * sizeM,
                          0.85f * out * std::sin(angle)},
                         random.uniform(0.2f, 0.27f) * sizeM});
    }
    puffs.push_back({{random.uniform(-0.1f, 0.1f) * sizeM, 0.2f * sizeM, 0.0f}, 0.3f * sizeM});
    Shape shape = blob(3, [&](glm::vec3 direction) { return reach(puffs, direction); });
    for (glm::vec3& position : shape.positions) position.y *= position.y < 0.0f ? 0.35f : 0.8f;
    return shape;
}

void clouds(Asset& asset) {
    asset.addGround(9.0f, 9.0f);
    const int white = asset.addMaterial({.name = "cloud", .color = {0.75f, 0.82f, 0.95f}});
    Random random(5064);
    const struct {
        const char* name;
        glm::vec3 at;
        float sizeM;
    } places[] = {{"cloud 1", {-0.95f, 0.75f, -0.6f}, 1.3f},
                  {"cloud 2", {0.95f, 1.0f, -0.75f}, 1.15f},
                  {"cloud 3", {-0.45f, 1.2f, 0.75f}, 1.0f},
                  {"cloud 4", {1.1f, 0.6f, 0.7f}, 1.1f}};
    for (const auto& place : places) {
        asset.addNode({.name = place.name,
                       .mesh = asset.addMesh(place.name, cloud(random, place.sizeM), white),
                       .translation = place.at});
    }
}

const Register kClouds{"clouds", clouds};

}  // namespace
}  // namespace penumbra::assets
