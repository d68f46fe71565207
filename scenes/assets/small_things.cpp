// Household-sized scenes: a gathering of game pieces, a table with chairs, a garden fence and a
// wind wheel.
#include <cmath>
#include <numbers>
#include <string>

#include "scenes/assets/asset.hpp"
#include "scenes/assets/random.hpp"

namespace penumbra::assets {
namespace {

/// About 2,100 triangles, as the first test scene of Arvo and Westerholm 2004 (2,148).
void gathering(Asset& asset) {
    asset.addGround(7.0f, 7.0f);
    const int red = asset.addMaterial({.name = "red", .color = {0.75f, 0.2f, 0.15f}});
    const int blue = asset.addMaterial({.name = "blue", .color = {0.15f, 0.35f, 0.7f}});
    const int wood = asset.addMaterial({.name = "wood", .color = {0.65f, 0.45f, 0.25f}});
    const int green = asset.addMaterial({.name = "green", .color = {0.2f, 0.55f, 0.25f}});

    const Shape pawn = lathe({{0.13f, 0.0f},
                              {0.13f, 0.05f},
                              {0.06f, 0.12f},
                              {0.045f, 0.3f},
                              {0.08f, 0.32f},
                              {0.04f, 0.35f},
                              {0.08f, 0.42f},
                              {0.06f, 0.48f},
                              {0.0f, 0.51f}},
                             10);
    const Shape ring = torus(0.17f, 0.045f, 12, 6);
    const Shape cone = lathe({{0.15f, 0.0f}, {0.0f, 0.42f}}, 12);
    const Shape ball = sphere(0.13f, 1);
    Shape stool = lathe({{0.19f, 0.34f}, {0.19f, 0.4f}}, 10);
    for (int leg = 0; leg < 3; ++leg) {
        const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(leg) / 3.0f;
        const glm::vec3 out(std::cos(angle), 0.0f, std::sin(angle));
        stool.append(rod(0.17f * out, 0.11f * out + glm::vec3(0, 0.35f, 0), 0.015f, 4));
    }

    // Places on a jittered grid, none within reach of another.
    Random random(2148);
    int cell = 0;
    const auto nextPlace = [&](float heightM) {
        const float x = 0.56f * (static_cast<float>(cell % 6) - 2.5f);
        const float z = 0.56f * (static_cast<float>(cell / 6) - 2.5f);
        cell = (cell + 7) % 36;
        const float jitterX = random.uniform(-0.1f, 0.1f), jitterZ = random.uniform(-0.1f, 0.1f);
        return placed({x + jitterX, heightM, z + jitterZ}, random.uniform(0.0f, 360.0f));
    };
    Shape pawns, rings, cones, blocks, balls, stools;
    for (int i = 0; i < 7; ++i) pawns.append(pawn, nextPlace(0.0f));
    for (int i = 0; i < 2; ++i) {
        rings.append(ring, nextPlace(0.215f) * placed({0, 0, 0}, 90.0f, {1, 0, 0}));
    }
    for (int i = 0; i < 4; ++i) cones.append(cone, nextPlace(0.0f));
    for (int i = 0; i < 12; ++i) {
        const float half = random.uniform(0.08f, 0.14f), height = random.uniform(0.12f, 0.6f);
        blocks.append(box({-half, 0.0f, -half}, {half, height, half}), nextPlace(0.0f));
    }
    for (int i = 0; i < 3; ++i) balls.append(ball, nextPlace(0.13f));
    for (int i = 0; i < 3; ++i) stools.append(stool, nextPlace(0.0f));
    asset.place("pawns", pawns, red);
    asset.place("rings", rings, blue);
    asset.place("cones", cones, green);
    asset.place("blocks", blocks, wood);
    asset.place("balls", balls, blue);
    asset.place("stools", stools, wood);
}

void contact(Asset& asset) {
    asset.addGround(8.0f, 8.0f);
    const int oak = asset.addMaterial({.name = "oak", .color = {0.6f, 0.4f, 0.2f}});
    const int paint = asset.addMaterial({.name = "paint", .color = {0.25f, 0.45f, 0.6f}});

    Shape table = box({-0.7f, 0.70f, -0.4f}, {0.7f, 0.74f, 0.4f});
    table.append(box({-0.62f, 0.62f, -0.32f}, {0.62f, 0.70f, -0.30f}));
    table.append(box({-0.62f, 0.62f, 0.30f}, {0.62f, 0.70f, 0.32f}));
    for (const float x : {-0.64f, 0.64f}) {
        for (const float z : {-0.34f, 0.34f}) {
            table.append(box({x - 0.025f, 0.0f, z - 0.025f}, {x + 0.025f, 0.70f, z + 0.025f}));
        }
    }
    asset.place("table", table, oak);

    Shape chair = box({-0.21f, 0.43f, -0.21f}, {0.21f, 0.46f, 0.21f});
    for (const float x : {-0.18f, 0.18f}) {
        chair.append(box({x - 0.017f, 0.0f, 0.16f}, {x + 0.017f, 0.43f, 0.194f}));
        chair.append(box({x - 0.017f, 0.0f, -0.2f}, {x + 0.017f, 0.92f, -0.166f}));
    }
    for (const float y : {0.58f, 0.7f, 0.82f}) {
        chair.append(box({-0.163f, y, -0.192f}, {0.163f, y + 0.07f, -0.174f}));
    }
    for (const float x : {-0.18f, 0.18f}) {
        chair.append(rod({x, 0.2f, -0.166f}, {x, 0.2f, 0.16f}, 0.012f, 8));
    }
    const int chairMesh = asset.addMesh("chair", chair, paint);
    asset.addNode({.name = "chair 1",
                   .mesh = chairMesh,
                   .translation = {-0.25f, 0.0f, 0.85f},
                   .rotation = glm::angleAxis(glm::radians(200.0f), glm::vec3(0, 1, 0))});
    asset.addNode({.name = "chair 2",
                   .mesh = chairMesh,
                   .translation = {1.15f, 0.0f, 0.3f},
                   .rotation = glm::angleAxis(glm::radians(-60.0f), glm::vec3(0, 1, 0)),
                   .scale = {1.05f, 1.0f, 0.95f}});
}

/// Every picket touches the ground and reaches 1.2 m above it, so that its shadow is sharp at the
/// foot and soft at the far end.
void fence(Asset& asset) {
    asset.addGround(10.0f, 12.0f, 1.0f);
    const int white = asset.addMaterial({.name = "picket", .color = {0.7f, 0.62f, 0.5f}});
    const int brown = asset.addMaterial({.name = "rail", .color = {0.45f, 0.3f, 0.2f}});
    const Shape picket = prism(
        {{-0.055f, 0.0f}, {0.055f, 0.0f}, {0.055f, 1.1f}, {0.0f, 1.22f}, {-0.055f, 1.1f}}, 0.025f);
    Shape pickets;
    constexpr int kCount = 17;
    for (int i = 0; i < kCount; ++i) {
        const float z = 1.7f - 0.22f * static_cast<float>(i);
        const float leanDeg = 2.0f * std::sin(1.7f * static_cast<float>(i));
        pickets.append(picket, placed({0, 0, z}, 90.0f) * placed({0, 0, 0}, leanDeg, {0, 0, 1}));
    }
    asset.place("pickets", pickets, white);
    Shape rails = box({-0.055f, 0.28f, -2.0f}, {-0.02f, 0.36f, 1.85f});
    rails.append(box({-0.055f, 0.86f, -2.0f}, {-0.02f, 0.94f, 1.85f}));
    asset.place("rails", rails, brown);
}

/// The wheel's node turns about its axle once in four seconds; the blades hang on the wheel and the
/// wheel on a post that is itself turned, so that the animation runs through a hierarchy.
void spinner(Asset& asset) {
    asset.addGround(7.0f, 7.0f);
    const int steel = asset.addMaterial({.name = "post", .color = {0.5f, 0.5f, 0.55f}});
    const int red =
        asset.addMaterial({.name = "blade", .color = {0.8f, 0.25f, 0.15f}, .doubleSided = true});
    const int post = asset.addNode(
        {.name = "post",
         .mesh = asset.addMesh(
             "post", lathe({{0.22f, 0.0f}, {0.22f, 0.04f}, {0.03f, 0.06f}, {0.025f, 0.9f}}, 24),
             steel),
         .rotation = glm::angleAxis(glm::radians(15.0f), glm::vec3(0, 1, 0))});
    const int wheel = asset.addNode(
        {.name = "wheel",
         .mesh = asset.addMesh(
             "hub", lathe({{0.0f, -0.06f}, {0.09f, -0.03f}, {0.09f, 0.05f}, {0.0f, 0.09f}}, 24),
             steel),
         .parent = post,
         .translation = {0.0f, 0.95f, 0.0f}});

    // A twisted blade: a sheet whose chord turns from steep at the hub to flat at the tip.
    Shape blade;
    constexpr std::uint32_t kSpans = 10;
    for (std::uint32_t i = 0; i <= kSpans; ++i) {
        const float t = static_cast<float>(i) / kSpans;
        const float pitch = glm::radians(glm::mix(40.0f, 12.0f, t));
        const float halfChord = 0.06f + 0.12f * std::sin(std::numbers::pi_v<float> * 0.75f * t);
        const glm::vec3 chord(0.0f, std::sin(pitch), std::cos(pitch));
        const glm::vec3 spine(0.07f + 0.93f * t, 0.0f, 0.0f);
        blade.addVertex(spine + halfChord * chord);
        blade.addVertex(spine - halfChord * chord);
    }
    for (std::uint32_t i = 0; i < kSpans; ++i) {
        blade.addQuad(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1);
    }
    const int bladeMesh = asset.addMesh("blade", blade, red);
    for (int i = 0; i < 5; ++i) {
        asset.addNode({.name = "blade " + std::to_string(i + 1),
                       .mesh = bladeMesh,
                       .parent = wheel,
                       .rotation = glm::angleAxis(glm::radians(72.0f * static_cast<float>(i)),
                                                  glm::vec3(0, 1, 0))});
    }
    std::vector<float> timesS;
    std::vector<glm::quat> turns;
    for (int quarter = 0; quarter <= 4; ++quarter) {
        timesS.push_back(static_cast<float>(quarter));
        turns.push_back(
            glm::angleAxis(glm::radians(90.0f * static_cast<float>(quarter)), glm::vec3(0, 1, 0)));
    }
    asset.animateRotation(wheel, timesS, turns);
}

const Register kGathering{"gathering", gathering};
const Register kContact{"contact", contact};
const Register kFence{"fence", fence};
const Register kSpinner{"spinner", spinner};

}  // namespace
}  // namespace penumbra::assets
