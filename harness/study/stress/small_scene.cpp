#include "harness/study/stress/small_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "core/sampling/sampling.hpp"
#include "core/scene/gltf_export.hpp"
#include "core/scene/placement.hpp"
#include "core/scene/scene_builder.hpp"
#include "harness/run/files.hpp"

namespace penumbra::stress {
namespace {

using namespace scene_detail;
using Triangle = std::array<std::uint32_t, 3>;

glm::dmat4 matrixOf(const Placement& placement) {
    glm::dmat4 m(1.0);
    if (placement.mirror) m = glm::scale(m, glm::dvec3(-1, 1, 1));
    constexpr glm::dvec3 kAxes[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
    const double angles[] = {placement.rotateDeg.z, placement.rotateDeg.y, placement.rotateDeg.x};
    for (int i = 0; i < 3; ++i)
        if (angles[i] != 0.0) m = glm::rotate(m, glm::radians(angles[i]), kAxes[i]);
    m = glm::scale(m, glm::dvec3(placement.scale));
    m[3] = glm::dvec4(placement.offset, 1.0);
    return m;
}

/// Another order of `list`, the same one every time.
template <class T>
void shuffle(std::vector<T>& list) {
    for (std::size_t i = list.size(); i > 1; --i)
        std::swap(list[i - 1], list[hash(17u, static_cast<std::uint32_t>(i)) % i]);
}

void duplicate(AssetPrimitive& primitive) {
    const std::vector<std::uint32_t> once = primitive.indices;
    for (std::size_t t = 0; t < once.size(); t += 3)
        primitive.indices.insert(primitive.indices.end(), {once[t], once[t + 2], once[t + 1]});
}

void splitEveryOther(AssetPrimitive& primitive) {
    std::vector<std::uint32_t> indices;
    for (std::size_t t = 0; t < primitive.indices.size(); t += 3) {
        const Triangle corner = {primitive.indices[t], primitive.indices[t + 1],
                                 primitive.indices[t + 2]};
        if (t / 3 % 2 == 1) {
            indices.insert(indices.end(), corner.begin(), corner.end());
            continue;
        }
        Triangle middle;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = corner[i], b = corner[(i + 1) % 3];
            middle[i] = static_cast<std::uint32_t>(primitive.positions.size());
            primitive.positions.push_back(0.5f * (primitive.positions[a] + primitive.positions[b]));
            primitive.normals.push_back(primitive.normals[a]);
            primitive.uvs.push_back(0.5f * (primitive.uvs[a] + primitive.uvs[b]));
        }
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            indices.insert(indices.end(), {a, b, c});
        };
        add(corner[0], middle[0], middle[2]);
        add(middle[0], corner[1], middle[1]);
        add(middle[2], middle[1], corner[2]);
        add(middle[0], middle[1], middle[2]);
    }
    primitive.indices = std::move(indices);
}

void shuffleTriangles(AssetPrimitive& primitive) {
    std::vector<Triangle> triangles;
    for (std::size_t t = 0; t < primitive.indices.size(); t += 3)
        triangles.push_back(
            {primitive.indices[t], primitive.indices[t + 1], primitive.indices[t + 2]});
    shuffle(triangles);
    primitive.indices.clear();
    for (const Triangle& t : triangles)
        primitive.indices.insert(primitive.indices.end(), t.begin(), t.end());
}

Asset assetOf(const SmallScene& scene) {
    Asset asset;
    asset.file = "stress.glb";
    asset.materials.resize(1);
    asset.emissions = {0.0};
    AssetNode root;
    root.name = "world";
    root.hasMatrix = true;
    root.matrix = matrixOf(scene.placement);
    asset.nodes = {root};
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const auto geometry = shapeOf(scene.bodies[i]).geometry();
        AssetPrimitive primitive;
        primitive.positions = geometry->positions;
        primitive.normals = geometry->normals;
        primitive.uvs = geometry->uvs;
        primitive.indices = geometry->indices;
        if (scene.mesh.split) splitEveryOther(primitive);
        if (scene.mesh.duplicated) duplicate(primitive);
        if (scene.mesh.shuffled) shuffleTriangles(primitive);
        AssetNode node;
        node.name = fmt::format("body{}", i);
        node.parent = 0;
        const int index = static_cast<int>(asset.nodes.size());
        asset.placements.push_back({node.name, index, static_cast<int>(asset.primitives.size())});
        asset.nodes.push_back(node);
        asset.primitives.push_back(std::move(primitive));
    }
    if (scene.mesh.shuffled) shuffle(asset.placements);
    return asset;
}

ScriptTrack trackOf(const Motion& motion, const glm::dmat4& world, double scale) {
    ScriptTrack track;
    const auto vector = [](const std::vector<double>& n) {
        glm::dvec4 v(0.0);
        for (std::size_t c = 0; c < n.size(); ++c) v[static_cast<int>(c)] = n[c];
        return v;
    };
    glm::dvec4 from = vector(motion.from), to = vector(motion.to);
    const auto place = [&](glm::dvec4& v) {
        v = glm::dvec4(glm::dvec3(world * glm::dvec4(glm::dvec3(v), 1.0)), 0.0);
    };
    if (motion.target == "light.position" || motion.target == "camera.position") {
        track.target = motion.target == "light.position" ? TrackTarget::lightPosition
                                                         : TrackTarget::cameraPosition;
        place(from);
        place(to);
    } else if (motion.target == "light.size") {
        track.target = TrackTarget::lightSize;
        from *= scale;
        to *= scale;
    } else {  // of a node, in the space of the scene
        track.target = TrackTarget::nodeTranslation;
        track.node = motion.target.substr(5, motion.target.rfind('.') - 5);
    }
    track.curve.times = {0.0, 1.0};
    track.curve.values = {from, to};
    return track;
}

Script scriptOf(const SmallScene& scene) {
    const glm::dmat4 world = matrixOf(scene.placement);
    const glm::dmat3 linear(world);
    const auto at = [&](const glm::dvec3& p) { return glm::dvec3(world * glm::dvec4(p, 1.0)); };
    Script script;
    script.file = "stress.toml";
    script.shows = "a hard case";
    script.asset = "stress.glb";
    ScriptLight light;
    light.position = at(scene.lightPosition);
    light.target = at(scene.lightTarget);
    light.size = scene.lightSize * scene.placement.scale;
    // The axes that the light has where the scene is not placed; they turn with the scene.
    const auto unplaced =
        lightFacing(scene.lightPosition, scene.lightTarget, scene.lightUp, scene.lightSize);
    if (unplaced) light.up = linear * unplaced->axisV;
    light.where = "light";
    script.light = light;
    ScriptCamera camera;
    camera.position = at(scene.cameraPosition);
    camera.target = at(scene.cameraTarget);
    camera.fovYDegrees = scene.fovYDeg;
    const auto unplacedCamera =
        cameraFacing(scene.cameraPosition, scene.cameraTarget, {}, glm::radians(scene.fovYDeg));
    if (unplacedCamera) camera.up = linear * unplacedCamera->up;
    camera.where = "camera";
    script.camera = camera;
    if (scene.motion) {
        script.timesS.clear();
        for (int i = 0; i < scene.motion->frames; ++i)
            script.timesS.push_back(static_cast<double>(i) / std::max(1, scene.motion->frames - 1));
        script.tracks = {trackOf(*scene.motion, world, scene.placement.scale)};
    }
    return script;
}

std::string list(const glm::dvec3& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

}  // namespace

std::shared_ptr<const Scene> SmallScene::build() const {
    return buildScene(assetOf(*this), scriptOf(*this));
}

void SmallScene::write(const std::filesystem::path& stem,
                       const std::vector<std::string>& comment) const {
    const auto scene = build();
    SceneFrame frame = scene->frame(0);
    const Script script = scriptOf(*this);
    // The script says where the light is, in doubles: written as a rectangle, it would be a caster.
    SceneFrame withoutLight = frame;
    withoutLight.light.halfU = withoutLight.light.halfV = 0.0;
    const Camera camera = withClipPlanes(*scene, frame, 0.0);
    const std::string glb = exportGltf(*scene, withoutLight, camera, 1.0);
    std::filesystem::path file = stem;
    writeFileAtomically(file += ".glb", glb);
    std::string text;
    for (const std::string& line : comment) text += "# " + line + "\n";
    text += fmt::format(
        "shows = \"a failure of `penumbra stress --random`\"\nasset = \"{}\"\n\n"
        "[camera]\nposition = {}\ntarget = {}\nup = {}\nfov_y = {}\n\n"
        "[light]\nposition = {}\ntarget = {}\nup = {}\nsize = [{}, {}]\n",
        file.filename().string(), list(script.camera->position), list(script.camera->target),
        list(*script.camera->up), script.camera->fovYDegrees, list(script.light->position),
        list(script.light->target), list(*script.light->up), script.light->size.x,
        script.light->size.y);
    file = stem;
    writeFileAtomically(file += ".toml", text);
}

}  // namespace penumbra::stress
