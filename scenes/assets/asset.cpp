#include "scenes/assets/asset.hpp"

#include <cstring>
#include <fstream>
#include <glm/gtc/quaternion.hpp>

namespace penumbra::assets {
namespace {

std::vector<double> numbers(glm::vec3 v) {
    return {v.x, v.y, v.z};
}

/// tinygltf hands its PNG encoder's output over only as a data URI.
std::vector<std::uint8_t> encodePng(const Texture& texture) {
    tinygltf::Image image;
    image.width = texture.width;
    image.height = texture.height;
    image.component = 4;
    image.bits = 8;
    image.pixel_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    image.image = texture.rgba;
    const std::string folder, file = texture.name + ".png";
    std::string uri, mimeType;
    std::vector<std::uint8_t> png;
    if (!tinygltf::WriteImageData(&folder, &file, &image, true, &uri, nullptr) ||
        !tinygltf::DecodeDataURI(&png, mimeType, uri, 0, false)) {
        throw std::runtime_error(file + ": the PNG encoder failed");
    }
    return png;
}

}  // namespace

Asset::Asset() {
    model_.asset.version = "2.0";
    model_.asset.generator = "penumbra_assets";
    model_.buffers.emplace_back();
    model_.scenes.emplace_back();
    model_.defaultScene = 0;
}

int Asset::addBufferView(const void* data, std::size_t bytes, int target) {
    std::vector<unsigned char>& buffer = model_.buffers[0].data;
    buffer.resize((buffer.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = bytes;
    view.target = target;
    buffer.resize(buffer.size() + bytes);
    std::memcpy(buffer.data() + view.byteOffset, data, bytes);
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
}

template <typename T>
int Asset::addAccessor(const std::vector<T>& values, int componentType, int type, int target) {
    tinygltf::Accessor accessor;
    accessor.bufferView = addBufferView(values.data(), values.size() * sizeof(T), target);
    accessor.componentType = componentType;
    accessor.type = type;
    accessor.count = values.size();
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
}

int Asset::addTexture(const Texture& texture) {
    const std::vector<std::uint8_t> png = encodePng(texture);
    tinygltf::Image image;
    image.name = texture.name;
    image.mimeType = "image/png";
    image.bufferView = addBufferView(png.data(), png.size(), 0);
    model_.images.push_back(image);
    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model_.samplers.push_back(sampler);
    tinygltf::Texture entry;
    entry.source = static_cast<int>(model_.images.size()) - 1;
    entry.sampler = static_cast<int>(model_.samplers.size()) - 1;
    model_.textures.push_back(entry);
    return static_cast<int>(model_.textures.size()) - 1;
}

int Asset::addMaterial(const MaterialSpec& spec) {
    tinygltf::Material material;
    material.name = spec.name;
    material.doubleSided = spec.doubleSided;
    material.pbrMetallicRoughness.baseColorFactor = {spec.color.r, spec.color.g, spec.color.b, 1.0};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.emissiveFactor = numbers(glm::vec3(spec.emissive ? 1.0f : 0.0f));
    if (spec.maskedTexture >= 0) {
        material.pbrMetallicRoughness.baseColorTexture.index = spec.maskedTexture;
        material.alphaMode = "MASK";
        material.alphaCutoff = 0.5;
    }
    model_.materials.push_back(material);
    return static_cast<int>(model_.materials.size()) - 1;
}

int Asset::addMesh(const std::string& name, const Shape& shape, int material, float creaseDeg) {
    const ShadedShape shaded = shade(shape, creaseDeg);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = material;
    const int positions = addAccessor(shaded.positions, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                      TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
    glm::vec3 lo = shaded.positions.front(), hi = lo;
    for (const glm::vec3& position : shaded.positions) {
        lo = glm::min(lo, position);
        hi = glm::max(hi, position);
    }
    model_.accessors.back().minValues = numbers(lo);
    model_.accessors.back().maxValues = numbers(hi);
    primitive.attributes["POSITION"] = positions;
    primitive.attributes["NORMAL"] = addAccessor(shaded.normals, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                                 TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
    if (!shaded.uvs.empty()) {
        primitive.attributes["TEXCOORD_0"] =
            addAccessor(shaded.uvs, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2,
                        TINYGLTF_TARGET_ARRAY_BUFFER);
    }
    primitive.indices = addAccessor(shaded.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                    TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
    return static_cast<int>(model_.meshes.size()) - 1;
}

int Asset::addCamera(float fovYDeg) {
    tinygltf::Camera camera;
    camera.type = "perspective";
    camera.perspective.yfov = glm::radians(fovYDeg);
    camera.perspective.aspectRatio = 1.0;
    camera.perspective.znear = 0.01;
    camera.perspective.zfar = 100.0;
    model_.cameras.push_back(camera);
    return static_cast<int>(model_.cameras.size()) - 1;
}

int Asset::addNode(const NodeSpec& spec) {
    tinygltf::Node node;
    node.name = spec.name;
    node.mesh = spec.mesh;
    node.camera = spec.camera;
    node.translation = numbers(spec.translation);
    node.rotation = {spec.rotation.x, spec.rotation.y, spec.rotation.z, spec.rotation.w};
    node.scale = numbers(spec.scale);
    const int index = static_cast<int>(model_.nodes.size());
    model_.nodes.push_back(node);
    (spec.parent < 0 ? model_.scenes[0].nodes
                     : model_.nodes[static_cast<std::size_t>(spec.parent)].children)
        .push_back(index);
    return index;
}

int Asset::place(const std::string& name, const Shape& shape, int material, float creaseDeg) {
    return addNode({.name = name, .mesh = addMesh(name, shape, material, creaseDeg)});
}

void Asset::addGround(float sizeXM, float sizeZM, float centreXM, float centreZM) {
    Shape ground;
    ground.append(plate(sizeXM, sizeZM), placed({centreXM, 0.0f, centreZM}));
    place("ground", ground, addMaterial({.name = "ground", .color = glm::vec3(0.8f)}));
}

void Asset::animateRotation(int node, const std::vector<float>& timesS,
                            const std::vector<glm::quat>& rotations) {
    tinygltf::AnimationSampler sampler;
    sampler.interpolation = "LINEAR";
    sampler.input = addAccessor(timesS, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 0);
    model_.accessors.back().minValues = {timesS.front()};
    model_.accessors.back().maxValues = {timesS.back()};
    std::vector<glm::vec4> values;  // glTF's order, whatever glm's is
    for (const glm::quat& q : rotations) values.emplace_back(q.x, q.y, q.z, q.w);
    sampler.output = addAccessor(values, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC4, 0);
    tinygltf::AnimationChannel channel;
    channel.sampler = 0;
    channel.target_node = node;
    channel.target_path = "rotation";
    tinygltf::Animation animation;
    animation.name = model_.nodes[static_cast<std::size_t>(node)].name;
    animation.samplers.push_back(sampler);
    animation.channels.push_back(channel);
    model_.animations.push_back(animation);
}

void Asset::write(const std::filesystem::path& file) {
    std::ofstream stream(file, std::ios::binary);
    tinygltf::TinyGLTF writer;
    const bool serialized = writer.WriteGltfSceneToStream(&model_, stream, false, true);
    stream.close();  // a full disk may show only here
    if (!serialized || !stream) throw std::runtime_error(file.string() + ": cannot be written");
}

glm::quat facing(glm::vec3 position, glm::vec3 target, glm::vec3 up) {
    return glm::quatLookAt(glm::normalize(target - position), up);
}

std::vector<Generator>& generators() {
    static std::vector<Generator> all;
    return all;
}

}  // namespace penumbra::assets
