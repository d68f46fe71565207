#include "core/scene/gltf_export.hpp"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <sstream>

#include "core/error.hpp"

namespace penumbra {
namespace {

constexpr std::size_t kMostBytes = (std::size_t{1} << 31) - 1;  // tinygltf counts in int
constexpr const char* kPunctual = "KHR_lights_punctual";

std::vector<double> numbers(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// A node's matrix: columns x, y, z and the translation.
std::vector<double> matrixOf(const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z,
                             const glm::dvec3& at) {
    return {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, at.x, at.y, at.z, 1};
}

int wrapOf(Wrap wrap) {
    switch (wrap) {
        case Wrap::mirroredRepeat:
            return TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
        case Wrap::clampToEdge:
            return TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
        case Wrap::repeat:
            break;
    }
    return TINYGLTF_TEXTURE_WRAP_REPEAT;
}

/// tinygltf hands its PNG encoder's output over only as a data URI.
std::vector<unsigned char> encodePng(const TextureImage& texture) {
    tinygltf::Image image;
    image.width = texture.width;
    image.height = texture.height;
    image.component = 4;
    image.bits = 8;
    image.pixel_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    image.image = texture.rgba;
    const std::string folder, file = "texture.png";
    std::string uri, mimeType;
    std::vector<unsigned char> png;
    if (!tinygltf::WriteImageData(&folder, &file, &image, true, &uri, nullptr) ||
        !tinygltf::DecodeDataURI(&png, mimeType, uri, 0, false))
        throw std::runtime_error(fmt::format("texture '{}': the PNG encoder failed", texture.name));
    return png;
}

class Exporter {
  public:
    Exporter(const Scene& scene, const SceneFrame& frame) : scene_(scene), frame_(frame) {
        model_.asset.version = "2.0";
        model_.asset.generator = "penumbra export";
        model_.buffers.emplace_back();
        model_.scenes.emplace_back();
        model_.defaultScene = 0;
        tinygltf::Node root;
        root.name = scene.id;
        root.translation = numbers(scene.origin);
        model_.nodes.push_back(root);
        model_.scenes[0].nodes = {0};
    }

    std::string run(const Camera& camera, double aspect) {
        for (const TextureImage& image : scene_.images) addTexture(image);
        for (const Material& material : scene_.materials) addMaterial(material);
        for (const Part& part : frame_.geometry->parts) addPart(part);
        addLight();
        addCamera(camera, aspect);
        std::ostringstream stream;
        tinygltf::TinyGLTF writer;
        if (!writer.WriteGltfSceneToStream(&model_, stream, false, true) || !stream)
            throw std::runtime_error(fmt::format("{}: glTF cannot be written", scene_.id));
        return std::move(stream).str();
    }

  private:
    template <class T>
    int addBufferView(std::span<const T> values, int target) {
        std::vector<unsigned char>& buffer = model_.buffers[0].data;
        const std::size_t begin = (buffer.size() + 3) / 4 * 4;
        if (begin + values.size_bytes() > kMostBytes)
            throw InputError(fmt::format(
                "{}: {} triangles and {} textures are more than the {} "
                "bytes that one .glb can hold",
                scene_.id, frame_.geometry->triangleCount(), scene_.images.size(), kMostBytes));
        buffer.resize(begin + values.size_bytes());
        std::memcpy(buffer.data() + begin, values.data(), values.size_bytes());
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = begin;
        view.byteLength = values.size_bytes();
        view.target = target;
        model_.bufferViews.push_back(view);
        return static_cast<int>(model_.bufferViews.size()) - 1;
    }

    template <class T>
    int addAccessor(std::span<const T> values, int componentType, int type, int target) {
        tinygltf::Accessor accessor;
        accessor.bufferView = addBufferView(values, target);
        accessor.componentType = componentType;
        accessor.type = type;
        accessor.count = values.size();
        model_.accessors.push_back(accessor);
        return static_cast<int>(model_.accessors.size()) - 1;
    }
    template <class T>
    int addVertices(std::span<const T> values, int type) {
        return addAccessor(values, TINYGLTF_COMPONENT_TYPE_FLOAT, type,
                           TINYGLTF_TARGET_ARRAY_BUFFER);
    }

    void addTexture(const TextureImage& in) {
        const std::vector<unsigned char> png = encodePng(in);
        tinygltf::Image image;
        image.name = in.name;
        image.mimeType = "image/png";
        image.bufferView = addBufferView(std::span(png), 0);
        model_.images.push_back(image);
        tinygltf::Sampler sampler;
        sampler.magFilter = sampler.minFilter =
            in.linear ? TINYGLTF_TEXTURE_FILTER_LINEAR : TINYGLTF_TEXTURE_FILTER_NEAREST;
        sampler.wrapS = wrapOf(in.wrapS);
        sampler.wrapT = wrapOf(in.wrapT);
        model_.samplers.push_back(sampler);
        tinygltf::Texture texture;
        texture.source = static_cast<int>(model_.images.size()) - 1;
        texture.sampler = static_cast<int>(model_.samplers.size()) - 1;
        model_.textures.push_back(texture);
    }

    void addMaterial(const Material& in) {
        tinygltf::Material material;
        material.name = in.name;
        material.doubleSided = true;
        auto& surface = material.pbrMetallicRoughness;
        surface.baseColorFactor = {in.baseColor.r, in.baseColor.g, in.baseColor.b, in.baseColor.a};
        surface.baseColorTexture.index = in.baseColorTexture;  // one texture for each image
        surface.metallicFactor = 0.0;
        if (in.masked) {
            material.alphaMode = "MASK";
            material.alphaCutoff = in.alphaCutoff;
        }
        model_.materials.push_back(material);
    }

    int addNode(tinygltf::Node node) {
        const int index = static_cast<int>(model_.nodes.size());
        model_.nodes.push_back(std::move(node));
        model_.nodes[0].children.push_back(index);
        return index;
    }

    void addMesh(const std::string& name, tinygltf::Primitive primitive, tinygltf::Node node = {}) {
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        tinygltf::Mesh mesh;
        mesh.name = name;
        mesh.primitives.push_back(std::move(primitive));
        model_.meshes.push_back(std::move(mesh));
        node.name = name;
        node.mesh = static_cast<int>(model_.meshes.size()) - 1;
        addNode(std::move(node));
    }

    int addPositions(std::span<const glm::vec3> positions) {
        const int accessor = addVertices(positions, TINYGLTF_TYPE_VEC3);
        glm::vec3 lo = positions.front(), hi = lo;
        for (const glm::vec3& p : positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
        model_.accessors.back().minValues = numbers(glm::dvec3(lo));
        model_.accessors.back().maxValues = numbers(glm::dvec3(hi));
        return accessor;
    }

    int addIndices(const std::vector<std::uint32_t>& indices) {
        return addAccessor(std::span(indices), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                           TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    }

    void addPart(const Part& part) {
        const Geometry& g = *frame_.geometry;
        const auto vertices = [&](const auto& all) {
            return std::span(all).subspan(part.firstVertex, part.vertexCount);
        };
        tinygltf::Primitive primitive;
        primitive.material = part.material;
        primitive.attributes["POSITION"] = addPositions(vertices(g.positions));
        primitive.attributes["NORMAL"] = addVertices(vertices(g.normals), TINYGLTF_TYPE_VEC3);
        if (scene_.materials[part.material].baseColorTexture >= 0)
            primitive.attributes["TEXCOORD_0"] = addVertices(vertices(g.uvs), TINYGLTF_TYPE_VEC2);
        std::vector<std::uint32_t> indices(part.indexCount);
        std::ranges::transform(std::span(g.indices).subspan(part.firstIndex, part.indexCount),
                               indices.begin(),
                               [&](std::uint32_t i) { return i - part.firstVertex; });
        primitive.indices = addIndices(indices);
        addMesh(part.name, std::move(primitive));
    }

    /// A square of side 2 in the node's XY plane: its size is in the matrix, in double.
    void addRectangle() {
        static constexpr std::array<glm::vec3, 4> kCorners = {
            {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}};
        const AreaLight& light = frame_.light;
        tinygltf::Material glow;
        glow.name = "light";
        glow.pbrMetallicRoughness.baseColorFactor = {0, 0, 0, 1};
        glow.emissiveFactor = {1, 1, 1};
        model_.materials.push_back(glow);
        tinygltf::Primitive primitive;
        primitive.material = static_cast<int>(model_.materials.size()) - 1;
        primitive.attributes["POSITION"] = addPositions(kCorners);
        primitive.indices = addIndices({0, 1, 2, 0, 2, 3});
        tinygltf::Node node;
        node.matrix = matrixOf(light.halfU * light.axisU, light.halfV * light.axisV, light.normal(),
                               light.centre);
        addMesh("light", std::move(primitive), std::move(node));
    }

    void addPoint() {
        tinygltf::Light light;
        light.type = "point";
        light.name = "light";
        light.color = {1, 1, 1};
        light.intensity = 1.0;
        model_.lights.push_back(light);
        tinygltf::Node node;
        node.name = "light";
        node.translation = numbers(frame_.light.centre);
        node.extensions[kPunctual] =
            tinygltf::Value(tinygltf::Value::Object{{"light", tinygltf::Value(0)}});
        addNode(std::move(node));
    }

    void addLight() {
        if (frame_.light.isPoint())
            addPoint();
        else
            addRectangle();
    }

    void addCamera(const Camera& in, double aspect) {
        tinygltf::Camera camera;
        camera.name = "camera";
        if (in.kind == Camera::Kind::perspective) {
            camera.type = "perspective";
            camera.perspective.yfov = in.fovYRad;
            camera.perspective.aspectRatio = aspect;
            camera.perspective.znear = in.nearM;
            camera.perspective.zfar = in.farM;
        } else {
            camera.type = "orthographic";
            camera.orthographic.xmag = in.magY * aspect;
            camera.orthographic.ymag = in.magY;
            camera.orthographic.znear = in.nearM;
            camera.orthographic.zfar = in.farM;
        }
        model_.cameras.push_back(camera);
        tinygltf::Node node;
        node.name = "camera";
        node.camera = 0;
        node.matrix = matrixOf(in.right, in.up, in.back, in.position);
        addNode(std::move(node));
    }

    const Scene& scene_;
    const SceneFrame& frame_;
    tinygltf::Model model_;
};

}  // namespace

Camera withClipPlanes(const Scene& scene, const SceneFrame& frame, double nearestM) {
    Camera camera = frame.camera;
    if (camera.nearM == 0.0) camera.nearM = nearestM > 0.0 ? 0.5 * nearestM : 1e-3 * scene.radiusM;
    if (camera.farM < Camera{}.farM) return camera;
    double farthestM = camera.nearM;
    for (const glm::vec3& p : frame.geometry->positions)
        farthestM = std::max(farthestM, glm::dot(camera.position - glm::dvec3(p), camera.back));
    camera.farM = 2.0 * farthestM;
    return camera;
}

std::string exportGltf(const Scene& scene, const SceneFrame& frame, const Camera& camera,
                       double aspect) {
    return Exporter(scene, frame).run(camera, aspect);
}

}  // namespace penumbra
