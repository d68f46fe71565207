#include "core/scene/gltf_accessor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

template <class T>
T loaded(const unsigned char* data) {
    T value;
    std::memcpy(&value, data, sizeof value);
    return value;
}

/// glTF 2.0 specification, section 3.6.2.2: the integer to float mappings.
float component(const unsigned char* data, int componentType) {
    switch (componentType) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return std::max(loaded<std::int8_t>(data) / 127.0f, -1.0f);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return static_cast<float>(*data) / 255.0f;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return std::max(loaded<std::int16_t>(data) / 32767.0f, -1.0f);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return loaded<std::uint16_t>(data) / 65535.0f;
        default:
            return loaded<float>(data);
    }
}

std::string typeName(int components, int componentType) {
    static constexpr const char* kShapes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::string shape = components >= 1 && components <= 4 ? kShapes[components - 1] : "MAT";
    switch (componentType) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return shape + " of BYTE";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return shape + " of UNSIGNED_BYTE";
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return shape + " of SHORT";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return shape + " of UNSIGNED_SHORT";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return shape + " of UNSIGNED_INT";
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return shape + " of FLOAT";
        default:
            return fmt::format("{} of component type {}", shape, componentType);
    }
}

}  // namespace

void AccessorReader::fail(const std::string& pointer, const std::string& what) const {
    failInput(file_, pointer, what);
}

AccessorReader::View AccessorReader::view(int index, const std::string& user) const {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.accessors.size()) {
        fail(user, fmt::format("accessor {} does not exist; the file has {}", index,
                               model_.accessors.size()));
    }
    const tinygltf::Accessor& accessor = model_.accessors[index];
    const std::string pointer = fmt::format("/accessors/{}", index);
    if (accessor.sparse.isSparse) fail(pointer, "sparse accessors are not supported yet");
    if (accessor.bufferView < 0) fail(pointer, "accessors without a buffer view are not supported");
    if (static_cast<std::size_t>(accessor.bufferView) >= model_.bufferViews.size()) {
        fail(pointer, fmt::format("buffer view {} does not exist; the file has {}",
                                  accessor.bufferView, model_.bufferViews.size()));
    }
    const tinygltf::BufferView& bytes = model_.bufferViews[accessor.bufferView];
    const int components =
        tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    const int componentBytes =
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
    if (components < 1 || componentBytes < 1) fail(pointer, "has an unknown component type");
    const std::size_t element = static_cast<std::size_t>(components) * componentBytes;
    const std::size_t stride = bytes.byteStride == 0 ? element : bytes.byteStride;
    if (stride < element) {
        fail(pointer,
             fmt::format("a stride of {} bytes is less than its elements of {}", stride, element));
    }
    if (accessor.count == 0) fail(pointer, "has no elements");
    const bool fits =
        accessor.byteOffset <= bytes.byteLength &&
        element <= bytes.byteLength - accessor.byteOffset &&
        accessor.count - 1 <= (bytes.byteLength - accessor.byteOffset - element) / stride;
    if (!fits) {
        fail(pointer, fmt::format("{} elements of {} bytes from byte {} do not fit into buffer "
                                  "view {} of {} bytes",
                                  accessor.count, stride, accessor.byteOffset, accessor.bufferView,
                                  bytes.byteLength));
    }
    return {model_.buffers[bytes.buffer].data.data() + bytes.byteOffset + accessor.byteOffset,
            accessor.count,
            stride,
            accessor.componentType,
            components,
            accessor.normalized};
}

std::vector<glm::vec4> AccessorReader::vectors(int accessor, int components, bool allowNormalised,
                                               const std::string& user, bool allowNonFinite) const {
    const View in = view(accessor, user);
    const bool integers = in.componentType >= TINYGLTF_COMPONENT_TYPE_BYTE &&
                          in.componentType <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    const bool typed = in.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
                       (integers && in.normalised && allowNormalised);
    if (in.components != components || !typed) {
        fail(user, fmt::format("accessor {} is {}{}; {}{} is read here", accessor,
                               in.normalised ? "normalised " : "",
                               typeName(in.components, in.componentType),
                               typeName(components, TINYGLTF_COMPONENT_TYPE_FLOAT),
                               allowNormalised ? " or of normalised integers" : ""));
    }
    const std::size_t componentBytes = static_cast<std::size_t>(
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(in.componentType)));
    std::vector<glm::vec4> out(in.count, glm::vec4(0.0f));
    for (std::size_t i = 0; i < in.count; ++i) {
        const unsigned char* data = in.data + i * in.strideBytes;
        for (int c = 0; c < components; ++c) {
            out[i][c] = component(data + c * componentBytes, in.componentType);
            if (!allowNonFinite && !std::isfinite(out[i][c])) {
                fail(user, fmt::format("element {} of accessor {} is {}", i, accessor,
                                       std::isnan(out[i][c]) ? "NaN" : "infinite"));
            }
        }
    }
    return out;
}

std::vector<std::uint32_t> AccessorReader::indices(int accessor, std::size_t vertexCount,
                                                   const std::string& user) const {
    const View in = view(accessor, user);
    const bool typed = in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                       in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                       in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (in.components != 1 || !typed || in.normalised) {
        fail(user, fmt::format("accessor {} is {}; indices are SCALAR of UNSIGNED_BYTE, "
                               "UNSIGNED_SHORT or UNSIGNED_INT",
                               accessor, typeName(in.components, in.componentType)));
    }
    std::vector<std::uint32_t> out(in.count);
    for (std::size_t i = 0; i < in.count; ++i) {
        const unsigned char* data = in.data + i * in.strideBytes;
        out[i] = in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ? *data
                 : in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                     ? loaded<std::uint16_t>(data)
                     : loaded<std::uint32_t>(data);
        if (out[i] >= vertexCount) {
            fail(user, fmt::format("index {} at position {} is out of range; there are {} vertices",
                                   out[i], i, vertexCount));
        }
    }
    return out;
}

std::vector<unsigned char> AccessorReader::bufferView(int index, const std::string& user) const {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.bufferViews.size()) {
        fail(user, fmt::format("buffer view {} does not exist; the file has {}", index,
                               model_.bufferViews.size()));
    }
    const tinygltf::BufferView& view = model_.bufferViews[index];
    const auto first =
        model_.buffers[view.buffer].data.begin() + static_cast<std::ptrdiff_t>(view.byteOffset);
    return {first, first + static_cast<std::ptrdiff_t>(view.byteLength)};
}

}  // namespace penumbra::scene_detail
