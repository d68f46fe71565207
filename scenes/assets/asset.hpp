#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenes/assets/shape.hpp"

namespace penumbra::assets {

/// An alpha-masked base colour: 8-bit RGBA, top row first, colour in sRGB.
struct Texture {
    std::string name;
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

struct MaterialSpec {
    std::string name;
    glm::vec3 color{0.8f};  ///< linear base colour factor
    bool doubleSided = false;
    bool emissive = false;   ///< a light: emissive factor 1
    int maskedTexture = -1;  ///< from Asset::addTexture: base colour and alpha, cut at 0.5
};

struct NodeSpec {
    std::string name;
    int mesh = -1;    ///< from Asset::addMesh
    int camera = -1;  ///< from Asset::addCamera
    int parent = -1;  ///< from Asset::addNode, -1 for a root
    glm::vec3 translation{0.0f};
    glm::quat rotation{1, 0, 0, 0};
    glm::vec3 scale{1.0f};
};

/// One glTF 2.0 scene in the making: float positions and normals, 32-bit indices, one buffer.
class Asset {
  public:
    Asset();

    int addTexture(const Texture& texture);
    int addMaterial(const MaterialSpec& material);
    /// Faces that meet at less than `creaseDeg` are shaded as one smooth surface.
    int addMesh(const std::string& name, const Shape& shape, int material, float creaseDeg = 40.0f);
    int addCamera(float fovYDeg);
    int addNode(const NodeSpec& node);
    /// A mesh and its node at the origin, both called `name`.
    int place(const std::string& name, const Shape& shape, int material, float creaseDeg = 40.0f);
    /// The ground: a light grey plate around (centreX, 0, centreZ).
    void addGround(float sizeXM, float sizeZM, float centreXM = 0.0f, float centreZM = 0.0f);
    /// Linear keyframes of a node's rotation.
    void animateRotation(int node, const std::vector<float>& timesS,
                         const std::vector<glm::quat>& rotations);

    /// Writes a binary .glb; throws std::runtime_error where the file cannot be written.
    void write(const std::filesystem::path& file);

  private:
    template <typename T>
    int addAccessor(const std::vector<T>& values, int componentType, int type, int target);
    int addBufferView(const void* data, std::size_t bytes, int target);

    tinygltf::Model model_;
};

/// The rotation that turns a camera, or a light facing -Z, at `position` towards `target`.
glm::quat facing(glm::vec3 position, glm::vec3 target, glm::vec3 up = {0, 1, 0});

/// Thrown by a generator whose source file is not installed: the asset is left out.
class SourceAbsent : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// An asset: its file stem and the code that fills it.
struct Generator {
    std::string name;
    void (*fill)(Asset&);
};

/// All registered generators, by name.
std::vector<Generator>& generators();

/// Put one at namespace scope beside each generator: `const Register entry{"fence", fence};`.
struct Register {
    Register(const char* name, void (*fill)(Asset&)) { generators().push_back({name, fill}); }
};

}  // namespace penumbra::assets
