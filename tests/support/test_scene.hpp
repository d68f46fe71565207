#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/analysis/frame_analysis.hpp"
#include "core/frame/frame.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra::test {

/// A scene of one frame, held in memory.
struct World {
    std::shared_ptr<const Geometry> geometry;
    AreaLight light;
    Camera camera{};
    std::vector<Material> materials = kOpaque;
    std::vector<TextureImage> images{};
    glm::dvec3 origin{0.0};
    std::uint32_t seed = 1;
};

/// One part for each (shape, material).
inline std::shared_ptr<const Geometry> joined(const std::vector<std::pair<Shape, int>>& shapes) {
    auto whole = std::make_shared<Geometry>();
    for (const auto& [shape, material] : shapes) {
        const auto piece = shape.geometry();
        Part part = piece->parts[0];
        part.material = material;
        part.firstVertex = static_cast<std::uint32_t>(whole->positions.size());
        part.firstIndex = static_cast<std::uint32_t>(whole->indices.size());
        whole->parts.push_back(part);
        const auto append = [](auto& to, const auto& from) {
            to.insert(to.end(), from.begin(), from.end());
        };
        append(whole->positions, piece->positions);
        append(whole->normals, piece->normals);
        append(whole->uvs, piece->uvs);
        for (const std::uint32_t i : piece->indices) whole->indices.push_back(part.firstVertex + i);
    }
    return whole;
}

/// The same world, every length times `factor`.
inline World scaled(World world, double factor) {
    auto geometry = std::make_shared<Geometry>(*world.geometry);
    for (glm::vec3& p : geometry->positions) p = glm::vec3(glm::dvec3(p) * factor);
    world.geometry = geometry;
    world.light.centre *= factor;
    world.light.halfU *= factor;
    world.light.halfV *= factor;
    world.camera.position *= factor;
    return world;
}

/// A perspective camera at `position`, z up in the image.
inline Camera lookingAt(const glm::dvec3& position, const glm::dvec3& target) {
    Camera camera;
    camera.position = position;
    camera.back = glm::normalize(position - target);
    camera.right = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), camera.back));
    camera.up = glm::cross(camera.back, camera.right);
    return camera;
}

/// Receivers of several G-buffers of one width, one below the other.
inline GBuffer stacked(const std::vector<GBuffer>& parts) {
    GBuffer all;
    all.width = parts.at(0).width;
    for (const GBuffer& part : parts) {
        const auto append = [&](auto member) {
            (all.*member).insert((all.*member).end(), (part.*member).begin(), (part.*member).end());
        };
        all.height += part.height;
        append(&GBuffer::position);
        append(&GBuffer::geometricNormal);
        append(&GBuffer::shadingNormal);
        append(&GBuffer::albedo);
        append(&GBuffer::mask);
        append(&GBuffer::irradianceUnshadowed);
    }
    return all;
}

/// The world as a scene.
class MemoryScene : public Scene {
  public:
    explicit MemoryScene(const World& world)
        : frame_{0.0, world.geometry, world.light, world.camera} {
        id = "memory";
        materials = world.materials;
        images = world.images;
        origin = world.origin;
        radiusM = boundsOf(world.geometry->positions).radius();
    }
    int frameCount() const override { return 1; }
    SceneFrame frame(int) const override { return frame_; }

  private:
    SceneFrame frame_;
};

/// A world and the points that are asked about, with all that a Frame refers to. Needs a context.
class TestFrame {
  public:
    /// `gbuffer` need not be what the world's camera sees.
    TestFrame(const World& world, GBuffer gbuffer)
        : scene_(world),
          tracer_(world.geometry, scene_.materials, scene_.images),
          gbuffer_(std::move(gbuffer)),
          textures_(uploadGBuffer(gbuffer_)),
          gpuMaterials_(scene_.materials, scene_.images),
          gpuGeometry_(world.geometry, gpuMaterials_),
          bounds_(boundLight(world.light, gbuffer_, *world.geometry)),
          analysis_(analyseFrame(scene_, tracer_, world.light, gbuffer_, bounds_)),
          frame_{
              scene_,  0,        world.light, bounds_,      world.camera,          world.geometry,
              tracer_, gbuffer_, textures_,   gpuGeometry_, analysis_.casterFacts, world.seed} {}
    TestFrame(const World& world, int size) : TestFrame(world, seen(world, size)) {}
    TestFrame(const TestFrame&) = delete;
    TestFrame& operator=(const TestFrame&) = delete;

    const Frame& operator*() const { return frame_; }
    const Frame* operator->() const { return &frame_; }
    EffectSet calledFor() const { return analysis_.calledFor(); }
    const FrameAnalysis& analysis() const { return analysis_; }

    std::vector<std::size_t> asked() const { return gbuffer_.asked(); }

  private:
    static GBuffer seen(const World& world, int size) {
        const MemoryScene scene(world);
        const Tracer tracer(world.geometry, scene.materials, scene.images);
        return renderGBuffer(tracer, scene.frame(0), scene, size, size);
    }

    MemoryScene scene_;
    Tracer tracer_;
    GBuffer gbuffer_;
    GBufferTextures textures_;
    GpuMaterials gpuMaterials_;
    GpuGeometry gpuGeometry_;
    LightBounds bounds_;
    FrameAnalysis analysis_;
    Frame frame_;
};

}  // namespace penumbra::test
