// A broad-leaved tree: thousands of small casters in many layers. One tree, two ways to make a
// leaf: a polygon, or a rectangle with an alpha-masked texture of that very outline.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "scenes/assets/asset.hpp"
#include "scenes/assets/random.hpp"

namespace penumbra::assets {
namespace {

constexpr float kTwoPi = 2.0f * std::numbers::pi_v<float>;
constexpr float kLeafLengthM = 0.13f;
constexpr float kLeafWidthM = 0.085f;
const glm::vec3 kLeafColor(0.18f, 0.45f, 0.08f);

/// Half the leaf's width, relative to kLeafWidthM / 2, at (0 base .. 1 tip) along it: polygonal, so
/// that both variants have the same outline.
constexpr float kOutlineAt[] = {0.0f, 0.25f, 0.6f, 1.0f};
constexpr float kOutlineWidth[] = {0.0f, 0.9f, 0.8f, 0.0f};

float outlineWidth(float along) {
    for (std::size_t i = 1; i < std::size(kOutlineAt); ++i) {
        if (along <= kOutlineAt[i]) {
            const float t = (along - kOutlineAt[i - 1]) / (kOutlineAt[i] - kOutlineAt[i - 1]);
            return glm::mix(kOutlineWidth[i - 1], kOutlineWidth[i], t);
        }
    }
    return 0.0f;
}

struct Tree {
    Shape wood;
    std::vector<glm::mat4> leaves;  ///< x across the leaf, y along it from the stalk, z its normal
};

glm::vec3 tilted(glm::vec3 direction, float awayRad, float aroundRad) {
    const glm::vec3 helper = std::abs(direction.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
    const glm::vec3 u = glm::normalize(glm::cross(helper, direction));
    const glm::vec3 v = glm::cross(direction, u);
    return std::cos(awayRad) * direction +
           std::sin(awayRad) * (std::cos(aroundRad) * u + std::sin(aroundRad) * v);
}

void addLeaf(Tree& tree, Random& random, glm::vec3 at, glm::vec3 twig) {
    const glm::vec3 along =
        glm::normalize(tilted(twig, random.uniform(0.6f, 1.5f), random.uniform(0.0f, kTwoPi)) -
                       glm::vec3(0.0f, 0.25f, 0.0f));
    // Leaves turn their faces to the sky, more or less.
    const glm::vec3 sky =
        tilted({0, 1, 0}, random.uniform(0.0f, 0.9f), random.uniform(0.0f, kTwoPi));
    const glm::vec3 across = glm::normalize(glm::cross(along, sky));
    const float size = random.uniform(0.75f, 1.2f);
    tree.leaves.emplace_back(glm::vec4(size * across, 0.0f), glm::vec4(size * along, 0.0f),
                             glm::vec4(size * glm::cross(across, along), 0.0f),
                             glm::vec4(at, 1.0f));
}

void grow(Tree& tree, Random& random, glm::vec3 from, glm::vec3 direction, float lengthM,
          float radiusM, int level) {
    constexpr int kTwigLevel = 3;
    constexpr int kSegments = 4;
    std::vector<glm::vec3> path{from};
    std::vector<float> radii{radiusM};
    glm::vec3 heading = direction;
    for (int i = 1; i <= kSegments; ++i) {
        heading = glm::normalize(tilted(heading, random.uniform(0.0f, level == 0 ? 0.08f : 0.22f),
                                        random.uniform(0.0f, kTwoPi)) +
                                 glm::vec3(0.0f, 0.04f, 0.0f));
        path.push_back(path.back() + heading * (lengthM / kSegments));
        radii.push_back(radiusM * (1.0f - 0.5f * static_cast<float>(i) / kSegments));
    }
    tree.wood.append(tube(path, radii, level == 0 ? 12 : (level == 1 ? 8 : 5)));
    if (level == kTwigLevel) {
        for (int i = 0; i < 16; ++i) {
            const float t = random.uniform(0.15f, 1.0f) * kSegments;
            const auto segment = std::min(static_cast<std::size_t>(t), path.size() - 2);
            const float within = t - static_cast<float>(segment);
            addLeaf(tree, random, glm::mix(path[segment], path[segment + 1], within), heading);
        }
        return;
    }
    const int children = level == 0 ? 9 : 6;
    const float turn = random.uniform(0.0f, kTwoPi);
    for (int i = 0; i < children; ++i) {
        const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(children);
        const float where = (level == 0 ? 0.5f + 0.5f * t : 0.25f + 0.75f * t) * kSegments;
        const auto segment = std::min(static_cast<std::size_t>(where), path.size() - 2);
        const glm::vec3 at =
            glm::mix(path[segment], path[segment + 1], where - static_cast<float>(segment));
        // The golden angle spreads the branches evenly around the stem.
        const float around = turn + 2.39996f * static_cast<float>(i);
        const float away = glm::mix(1.15f, 0.35f, level == 0 ? t : 0.6f * t);
        const float size = glm::mix(1.0f, 0.7f, t) * random.uniform(0.85f, 1.1f);
        grow(tree, random, at, glm::normalize(tilted(heading, away, around)),
             lengthM * (level == 0 ? 0.6f : 0.55f) * size, radiusM * 0.42f, level + 1);
    }
}

Tree makeTree() {
    Tree tree;
    Random random(20061);
    grow(tree, random, {0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, 1.7f, 0.1f, 0);
    return tree;
}

Shape leafPolygon() {
    Shape leaf;
    const std::uint32_t base = leaf.addVertex({0.0f, 0.0f, 0.0f});
    const auto side = [&](float sign, std::size_t i) {
        return leaf.addVertex(
            {sign * 0.5f * kLeafWidthM * kOutlineWidth[i], kLeafLengthM * kOutlineAt[i], 0.0f});
    };
    const std::uint32_t right1 = side(1, 1), right2 = side(1, 2);
    const std::uint32_t tip = leaf.addVertex({0.0f, kLeafLengthM, 0.0f});
    const std::uint32_t left2 = side(-1, 2), left1 = side(-1, 1);
    leaf.addTriangle(base, right1, left1);
    leaf.addQuad(left1, right1, right2, left2);
    leaf.addTriangle(left2, right2, tip);
    return leaf;
}

Shape leafRectangle() {
    Shape leaf;
    const float x = 0.5f * kLeafWidthM;
    leaf.positions = {{-x, 0, 0}, {x, 0, 0}, {x, kLeafLengthM, 0}, {-x, kLeafLengthM, 0}};
    leaf.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    leaf.addQuad(0, 1, 2, 3);
    return leaf;
}

/// Alpha is the outline's coverage of each texel, so that the cut at 0.5 follows the polygon.
Texture leafTexture() {
    constexpr int kSize = 64;
    constexpr int kSubsamples = 8;
    Texture texture{.name = "leaf", .width = kSize, .height = kSize, .rgba = {}};
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            int inside = 0;
            for (int s = 0; s < kSubsamples * kSubsamples; ++s) {
                const float u = (static_cast<float>(x) +
                                 (static_cast<float>(s % kSubsamples) + 0.5f) / kSubsamples) /
                                kSize;
                const float v = (static_cast<float>(y) +
                                 (static_cast<float>(s / kSubsamples) + 0.5f) / kSubsamples) /
                                kSize;
                inside += std::abs(2.0f * u - 1.0f) < outlineWidth(1.0f - v) ? 1 : 0;
            }
            const auto alpha = static_cast<std::uint8_t>(
                (255 * inside + kSubsamples * kSubsamples / 2) / (kSubsamples * kSubsamples));
            const bool rib = std::abs(x - kSize / 2) < 2;
            const std::uint8_t shade = rib ? 255 : 225;
            texture.rgba.insert(texture.rgba.end(), {shade, shade, shade, alpha});
        }
    }
    return texture;
}

void tree(Asset& asset, const Shape& leaf, int leafMaterial) {
    const Tree made = makeTree();
    asset.addGround(14.0f, 14.0f);
    const int bark = asset.addMaterial({.name = "bark", .color = {0.35f, 0.24f, 0.15f}});
    asset.place("wood", made.wood, bark, 60.0f);
    Shape leaves;
    for (const glm::mat4& place : made.leaves) leaves.append(leaf, place);
    asset.place("leaves", leaves, leafMaterial);
}

void foliage(Asset& asset) {
    tree(asset, leafPolygon(),
         asset.addMaterial({.name = "leaf", .color = kLeafColor, .doubleSided = true}));
}

void foliageMasked(Asset& asset) {
    const int texture = asset.addTexture(leafTexture());
    tree(asset, leafRectangle(),
         asset.addMaterial(
             {.name = "leaf", .color = kLeafColor, .doubleSided = true, .maskedTexture = texture}));
}

const Register kFoliage{"foliage", foliage};
const Register kFoliageMasked{"foliage_masked", foliageMasked};

}  // namespace
}  // namespace penumbra::assets
