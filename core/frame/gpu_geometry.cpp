#include "core/frame/gpu_geometry.hpp"

#include <array>
#include <cstdint>
#include <map>

namespace penumbra {
namespace {

GLint glWrap(Wrap wrap) {
    switch (wrap) {
        case Wrap::repeat:
            return GL_REPEAT;
        case Wrap::mirroredRepeat:
            return GL_MIRRORED_REPEAT;
        case Wrap::clampToEdge:
            return GL_CLAMP_TO_EDGE;
    }
    return GL_REPEAT;
}

gl::Texture uploadRgba(int width, int height, const std::uint8_t* rgba) {
    gl::Texture texture = gl::Texture::create2D(GL_SRGB8_ALPHA8, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture.id(), 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    return texture;
}

gl::Texture uploadImage(const TextureImage& image) {
    gl::Texture texture = uploadRgba(image.width, image.height, image.rgba.data());
    const GLint filter = image.linear ? GL_LINEAR : GL_NEAREST;
    glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, filter);
    glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, glWrap(image.wrapS));
    glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, glWrap(image.wrapT));
    return texture;
}

template <class T>
gl::Buffer uploadArray(const std::vector<T>& values) {
    return gl::Buffer::create(values.size() * sizeof(T), values.data());
}

template <class T>
void attribute(const gl::VertexArray& vertexArray, GLuint index, const gl::Buffer& buffer) {
    glVertexArrayVertexBuffer(vertexArray.id(), index, buffer.id(), 0, sizeof(T));
    glVertexArrayAttribFormat(vertexArray.id(), index, T::length(), GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vertexArray.id(), index, index);
    glEnableVertexArrayAttrib(vertexArray.id(), index);
}

void setAlphaUniforms(GLuint program, const Material* masked) {
    glProgramUniform1i(program, glGetUniformLocation(program, "alphaMasked"), masked ? 1 : 0);
    if (!masked) return;
    glProgramUniform1f(program, glGetUniformLocation(program, "alphaCutoff"), masked->alphaCutoff);
    glProgramUniform1f(program, glGetUniformLocation(program, "alphaFactor"), masked->baseColor.a);
}

}  // namespace

GpuMaterials::GpuMaterials(const std::vector<Material>& materials,
                           const std::vector<TextureImage>& images)
    : materials_(materials), textures_(images.size()) {
    for (const Material& material : materials) {
        if (material.baseColorTexture < 0) continue;
        const auto image = static_cast<std::size_t>(material.baseColorTexture);
        if (!textures_[image]) textures_[image] = uploadImage(images[image]);
    }
    constexpr std::array<std::uint8_t, 4> kWhite = {255, 255, 255, 255};
    white_ = uploadRgba(1, 1, kWhite.data());
}

void GpuMaterials::bind(int material, GLuint unit) const {
    const int image = materials_[static_cast<std::size_t>(material)].baseColorTexture;
    const gl::Texture& texture = image < 0 ? white_ : textures_[static_cast<std::size_t>(image)];
    texture.bind(unit);
}

GpuGeometry::GpuGeometry(std::shared_ptr<const Geometry> geometry, const GpuMaterials& materials)
    : geometry_(std::move(geometry)), materials_(&materials) {
    // Parts by batch: -1 (all opaque ones) first, then each masked material.
    std::map<int, std::vector<std::size_t>> partsOfBatch;
    for (std::size_t p = 0; p < geometry_->parts.size(); ++p) {
        const int material = geometry_->parts[p].material;
        const bool masked = materials.materials()[static_cast<std::size_t>(material)].masked;
        partsOfBatch[masked ? material : -1].push_back(p);
    }
    std::vector<std::uint32_t> indices;
    indices.reserve(geometry_->indices.size());
    for (const auto& [material, parts] : partsOfBatch) {
        batches_.push_back({material, parts_.size(), parts_.size() + parts.size()});
        for (const std::size_t p : parts) {
            const Part& part = geometry_->parts[p];
            parts_.push_back({p, static_cast<std::uint32_t>(indices.size()), part.indexCount});
            const auto first = geometry_->indices.begin() + part.firstIndex;
            indices.insert(indices.end(), first, first + part.indexCount);
        }
    }

    positions_ = uploadArray(geometry_->positions);
    uvs_ = uploadArray(geometry_->uvs);
    normals_ = uploadArray(geometry_->normals);
    indices_ = uploadArray(indices);
    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    vertexArray_ = gl::VertexArray(id);
    attribute<glm::vec3>(vertexArray_, 0, positions_);
    attribute<glm::vec2>(vertexArray_, 1, uvs_);
    attribute<glm::vec3>(vertexArray_, 2, normals_);
    glVertexArrayElementBuffer(id, indices_.id());
}

void GpuGeometry::drawParts(GLuint program, std::size_t first, std::size_t end, int instances,
                            std::span<const PartDraw> how) const {
    const GLint rasterSteps = glGetUniformLocation(program, "rasterSteps");
    const auto howOf = [&](std::size_t i) {
        return how.empty() ? PartDraw{} : how[parts_[i].part];
    };
    for (std::size_t last = first; first < end; first = last) {
        const PartDraw part = howOf(first);
        std::uint32_t indexCount = 0;
        for (; last < end && howOf(last) == part; ++last) indexCount += parts_[last].indexCount;
        if (!part.drawn || indexCount == 0) continue;
        if (part.culled == GL_NONE) {
            glDisable(GL_CULL_FACE);
        } else {
            glEnable(GL_CULL_FACE);
            glCullFace(part.culled);
        }
        if (rasterSteps >= 0) glProgramUniform1f(program, rasterSteps, part.rasterSteps);
        const auto offset =
            static_cast<std::uintptr_t>(parts_[first].firstIndex) * sizeof(std::uint32_t);
        glDrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(indexCount), GL_UNSIGNED_INT,
                                reinterpret_cast<const void*>(offset), instances);
    }
    glDisable(GL_CULL_FACE);
}

void GpuGeometry::draw(GLuint program, bool alphaMask, int instances,
                       std::span<const PartDraw> how) const {
    glBindVertexArray(vertexArray_.id());
    if (!alphaMask) {
        setAlphaUniforms(program, nullptr);
        drawParts(program, 0, parts_.size(), instances, how);
    } else {
        for (const Batch& batch : batches_) {
            const Material* masked =
                batch.material < 0
                    ? nullptr
                    : &materials_->materials()[static_cast<std::size_t>(batch.material)];
            setAlphaUniforms(program, masked);
            if (masked) materials_->bind(batch.material, 0);
            drawParts(program, batch.firstPart, batch.endPart, instances, how);
        }
    }
    glBindVertexArray(0);
}

}  // namespace penumbra
