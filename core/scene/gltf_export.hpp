#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace penumbra {

/// The camera with clip distances that any renderer can use: where a camera has none (0 and
/// infinity), half the distance to the nearest surface that it shows, `nearestM` in depth (0: it
/// shows none), and twice that to the farthest vertex. Neither cuts off anything seen.
Camera withClipPlanes(const Scene& scene, const SceneFrame& frame, double nearestM);

/// One frame as a binary glTF 2.0 file of its own, from which loadScene() makes the same frame:
/// the triangles in world space, one node a part; materials with base colour, alpha mask and
/// embedded PNG textures, all double-sided; the area light as an emissive rectangle that faces
/// where it emits; `camera` for images of width / height `aspect`. All of it hangs below one node
/// that carries Scene::origin, so that float positions lose nothing however far away that is.
///
/// A point light has no rectangle; it is written as KHR_lights_punctual, which loadScene() reads
/// as a point light there that faces the scene's centre. Throws InputError for a frame whose buffers would exceed the 2 GiB of
/// a .glb.
std::string exportGltf(const Scene& scene, const SceneFrame& frame, const Camera& camera,
                       double aspect);

}  // namespace penumbra
