// Scenes with a known answer: rectangles and a sphere over a plate, axis-aligned, in the numbers of
// the closed forms that certify the references.
#include "scenes/assets/asset.hpp"

namespace penumbra::assets {
namespace {

/// A double-sided sheet, extents (x, z) from `lo` to `hi`, at the height `heightM`.
Shape sheet(glm::vec2 lo, glm::vec2 hi, float heightM) {
    const glm::vec2 centre = 0.5f * (lo + hi), size = hi - lo;
    Shape shape;
    shape.append(plate(size.x, size.y), placed({centre.x, heightM, centre.y}));
    return shape;
}

/// The light and the camera travel inside the asset here: the route of assets made elsewhere.
void parallelRectangle(Asset& asset) {
    asset.addGround(6.0f, 6.0f);
    const int caster =
        asset.addMaterial({.name = "caster", .color = {0.75f, 0.25f, 0.2f}, .doubleSided = true});
    asset.place("caster", sheet({-0.4f, -0.2f}, {0.35f, 0.6f}, 2.0f), caster);

    const int glow =
        asset.addMaterial({.name = "light", .color = glm::vec3(0.0f), .emissive = true});
    asset.addNode({.name = "light",
                   .mesh = asset.addMesh("light", plate(2.0f, 1.0f), glow),
                   .translation = {0.0f, 5.0f, 0.0f},
                   .rotation = glm::angleAxis(glm::radians(180.0f), glm::vec3(1, 0, 0))});
    const glm::vec3 eye(0.0f, 3.9f, 3.6f);
    asset.addNode({.name = "camera",
                   .camera = asset.addCamera(40.0f),
                   .translation = eye,
                   .rotation = facing(eye, {0.0f, 0.0f, 0.2f})});
}

/// The sheet's other three edges lie too far out to shade what the camera sees.
void halfPlane(Asset& asset) {
    asset.addGround(14.0f, 14.0f);
    const int caster =
        asset.addMaterial({.name = "caster", .color = {0.2f, 0.4f, 0.7f}, .doubleSided = true});
    asset.place("caster", sheet({0.0f, -6.0f}, {6.0f, 6.0f}, 1.5f), caster);
}

/// Under a light at height 4 both sheets throw shadows of the same size: with its node at
/// (-0.48, 2, 0) the upper one's edges project onto those of the lower.
void twoLayers(Asset& asset) {
    asset.addGround(7.0f, 7.0f);
    const int lower =
        asset.addMaterial({.name = "lower", .color = {0.75f, 0.55f, 0.15f}, .doubleSided = true});
    const int upper =
        asset.addMaterial({.name = "upper", .color = {0.2f, 0.45f, 0.7f}, .doubleSided = true});
    asset.place("lower", sheet({-1.2f, -1.0f}, {0.0f, 1.0f}, 1.5f), lower);
    asset.addNode({.name = "upper",
                   .mesh = asset.addMesh("upper", plate(0.96f, 1.6f), upper),
                   .translation = {-0.48f, 2.0f, 0.0f}});
}

void spherePlate(Asset& asset) {
    asset.addGround(7.0f, 7.0f);
    const int ball = asset.addMaterial({.name = "ball", .color = {0.8f, 0.3f, 0.2f}});
    asset.addNode({.name = "ball",
                   .mesh = asset.addMesh("ball", sphere(0.6f, 5), ball),
                   .translation = {0.0f, 1.0f, 0.0f}});
}

/// Three staggered sheets: the lower ones' penumbrae fall into the umbra of those above, where
/// filtered depth distributions bleed.
void layers(Asset& asset) {
    asset.addGround(9.0f, 9.0f);
    const int top =
        asset.addMaterial({.name = "top", .color = {0.7f, 0.25f, 0.2f}, .doubleSided = true});
    const int middle =
        asset.addMaterial({.name = "middle", .color = {0.25f, 0.6f, 0.3f}, .doubleSided = true});
    const int bottom =
        asset.addMaterial({.name = "bottom", .color = {0.2f, 0.4f, 0.7f}, .doubleSided = true});
    asset.place("top", sheet({-0.9f, -0.9f}, {0.5f, 0.5f}, 2.2f), top);
    asset.place("middle", sheet({-0.6f, -0.4f}, {1.1f, 0.9f}, 1.4f), middle);
    asset.place("bottom", sheet({-1.5f, 0.0f}, {0.5f, 1.3f}, 0.6f), bottom);
}

/// The receiver hangs at a hinge under the caster's bars; tilting it down carries its far end away
/// from the caster and widens the penumbrae on it.
void recedingReceiver(Asset& asset) {
    const int plank = asset.addMaterial({.name = "caster", .color = {0.75f, 0.45f, 0.15f}});
    Shape bars;
    for (int i = 0; i < 5; ++i) {
        const float z = -1.0f + 0.5f * static_cast<float>(i);
        bars.append(box({-1.8f, 0.3f, z - 0.08f}, {1.5f, 0.36f, z + 0.08f}));
    }
    for (const float x : {-1.4f, 1.1f}) {
        bars.append(box({x - 0.08f, 0.36f, -1.2f}, {x + 0.08f, 0.42f, 1.2f}));
    }
    asset.place("bars", bars, plank);

    Shape receiver;
    receiver.append(plate(9.0f, 10.0f), placed({4.5f, 0.0f, -1.0f}));
    const int grey =
        asset.addMaterial({.name = "receiver", .color = glm::vec3(0.8f), .doubleSided = true});
    asset.addNode({.name = "receiver",
                   .mesh = asset.addMesh("receiver", receiver, grey),
                   .translation = {-2.0f, 0.0f, 0.0f}});
}

const Register kParallelRectangle{"parallel_rectangle", parallelRectangle};
const Register kHalfPlane{"half_plane", halfPlane};
const Register kTwoLayers{"two_layers", twoLayers};
const Register kSpherePlate{"sphere_plate", spherePlate};
const Register kLayers{"layers", layers};
const Register kRecedingReceiver{"receding_receiver", recedingReceiver};

}  // namespace
}  // namespace penumbra::assets
