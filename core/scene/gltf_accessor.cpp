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

/// An unsigned integer of 8, 16 or 32 bits.
std::uint32_t unsignedAt(const unsigned char* data, int componentBytes) {
    return componentBytes == 1   ? *data
           : componentBytes == 2 ? loaded<std::uint16_t>(data)
                                 : loaded<std::uint32_t>(data);
}

/// glTF 2.0 specification, section 3.6.2.2: the integer to float mappings.
float component(const unsigned char* data, int componentType, bool normalised) {
    switch (componentType) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return normalised ? std::max(loaded<std::int8_t>(data) / 127.0f, -1.0f)
                              : loaded<std::int8_t>(data);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return static_cast<float>(*data) / (normalised ? 255.0f : 1.0f);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return normalised ? std::max(loaded<std::int16_t>(data) / 32767.0f, -1.0f)
                              : loaded<std::int16_t>(data);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return loaded<std::uint16_t>(data) / (normalised ? 65535.0f : 1.0f);
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

bool isSmallInteger(int componentType) {
    return componentType >= TINYGLTF_COMPONENT_TYPE_BYTE &&
           componentType <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
}

}  // namespace

void AccessorReader::fail(const std::string& pointer, const std::string& what) const {
    failInput(file_, pointer, what);
}

const unsigned char* AccessorReader::Source::element(std::size_t index) const {
    const auto found = std::lower_bound(replaced.begin(), replaced.end(), index);
    if (found != replaced.end() && *found == index) {
        return values + static_cast<std::size_t>(found - replaced.begin()) * elementBytes;
    }
    return data ? data + index * strideBytes : nullptr;
}

const tinygltf::BufferView& AccessorReader::viewAt(int index, const std::string& pointer) const {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.bufferViews.size()) {
        fail(pointer, fmt::format("buffer view {} does not exist; the file has {}", index,
                                  model_.bufferViews.size()));
    }
    return model_.bufferViews[index];
}

const unsigned char* AccessorReader::inView(int view, std::size_t byteOffset, std::size_t count,
                                            std::size_t elementBytes, std::size_t strideBytes,
                                            const std::string& pointer) const {
    const tinygltf::BufferView& bytes = viewAt(view, pointer);
    const bool fits = byteOffset <= bytes.byteLength &&
                      elementBytes <= bytes.byteLength - byteOffset &&
                      count - 1 <= (bytes.byteLength - byteOffset - elementBytes) / strideBytes;
    if (!fits) {
        fail(pointer, fmt::format("{} elements of {} bytes from byte {} do not fit into buffer "
                                  "view {} of {} bytes",
                                  count, strideBytes, byteOffset, view, bytes.byteLength));
    }
    return model_.buffers[bytes.buffer].data.data() + bytes.byteOffset + byteOffset;
}

const AccessorReader::Source& AccessorReader::source(int index, const std::string& user) {
    if (const auto known = sources_.find(index); known != sources_.end()) return known->second;
    if (index < 0 || static_cast<std::size_t>(index) >= model_.accessors.size()) {
        fail(user, fmt::format("accessor {} does not exist; the file has {}", index,
                               model_.accessors.size()));
    }
    Source out = opened(index);
    if (model_.accessors[index].sparse.isSparse) {
        openSparse(model_.accessors[index], fmt::format("/accessors/{}", index), out);
    }
    return sources_.emplace(index, std::move(out)).first->second;
}

AccessorReader::Source AccessorReader::opened(int index) const {
    const tinygltf::Accessor& accessor = model_.accessors[index];
    const std::string pointer = fmt::format("/accessors/{}", index);
    Source out;
    out.components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    out.componentBytes =
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
    if (out.components < 1 || out.componentBytes < 1)
        fail(pointer, "has an unknown component type");
    if (accessor.count == 0) fail(pointer, "has no elements");
    out.count = accessor.count;
    out.componentType = accessor.componentType;
    out.normalised = accessor.normalized;
    out.elementBytes = static_cast<std::size_t>(out.components) * out.componentBytes;
    if (accessor.bufferView < 0) return out;
    const std::size_t stride = viewAt(accessor.bufferView, pointer).byteStride;
    out.strideBytes = stride == 0 ? out.elementBytes : stride;
    if (out.strideBytes < out.elementBytes) {
        fail(pointer, fmt::format("a stride of {} bytes is less than its elements of {}", stride,
                                  out.elementBytes));
    }
    out.data = inView(accessor.bufferView, accessor.byteOffset, out.count, out.elementBytes,
                      out.strideBytes, pointer);
    return out;
}

/// glTF 2.0 specification, section 3.6.2.3.
void AccessorReader::openSparse(const tinygltf::Accessor& accessor, const std::string& pointer,
                                Source& out) {
    const auto& sparse = accessor.sparse;
    const std::string at = pointer + "/sparse";
    const auto count = static_cast<std::size_t>(std::max(sparse.count, 0));
    if (count == 0 || count > out.count) {
        fail(at + "/count", fmt::format("{} is not from 1 to the accessor's count of {}",
                                        sparse.count, out.count));
    }
    const int type = sparse.indices.componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
        fail(at + "/indices/componentType", fmt::format("{} is not one of 5121, 5123, 5125", type));
    }
    const int indexBytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type));
    const auto step = static_cast<std::size_t>(indexBytes);
    const unsigned char* const indices =
        inView(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
               count, step, step, at + "/indices");
    out.values =
        inView(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), count,
               out.elementBytes, out.elementBytes, at + "/values");
    budget_.charge(count, sizeof(std::uint32_t), at, "its indices");
    out.replaced.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t index = unsignedAt(indices + i * step, indexBytes);
        if (index >= out.count || (i > 0 && index <= out.replaced.back())) {
            fail(at + "/indices",
                 fmt::format("index {} at position {} is out of range or does not increase; the "
                             "accessor has {} elements",
                             index, i, out.count));
        }
        out.replaced.push_back(index);
    }
}

std::size_t AccessorReader::count(int accessor, const std::string& user) {
    return source(accessor, user).count;
}

int AccessorReader::components(int accessor, const std::string& user) {
    return source(accessor, user).components;
}

bool AccessorReader::hasData(int accessor, const std::string& user) {
    const Source& in = source(accessor, user);
    return in.data || in.values;
}

void AccessorReader::requireInRange(const Source& in, std::span<const std::uint32_t> elements,
                                    int accessor, const std::string& user) const {
    for (const std::uint32_t i : elements) {
        if (i < in.count) continue;
        fail(user,
             fmt::format("accessor {} has {} elements; element {} is used", accessor, in.count, i));
    }
}

std::vector<glm::vec4> AccessorReader::vectors(int accessor, const Wanted& wanted,
                                               const std::string& user) {
    const std::size_t all = count(accessor, user);
    budget_.charge(all, sizeof(std::uint32_t), user, "its elements");
    std::vector<std::uint32_t> elements(all);
    for (std::size_t i = 0; i < all; ++i) elements[i] = static_cast<std::uint32_t>(i);
    return vectors(accessor, wanted, user, elements);
}

std::vector<glm::vec4> AccessorReader::vectors(int accessor, const Wanted& wanted,
                                               const std::string& user,
                                               std::span<const std::uint32_t> elements) {
    const Source& in = source(accessor, user);
    const bool typed = in.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
                       (isSmallInteger(in.componentType) &&
                        (wanted.integers == Integers::any ||
                         (wanted.integers == Integers::normalised && in.normalised)));
    if (in.components != wanted.components || !typed) {
        const char* const also = wanted.integers == Integers::none ? ""
                                 : wanted.integers == Integers::normalised
                                     ? " or of normalised integers"
                                     : " or of integers";
        fail(user, fmt::format("accessor {} is {}{}; {}{} is read here", accessor,
                               in.normalised ? "normalised " : "",
                               typeName(in.components, in.componentType),
                               typeName(wanted.components, TINYGLTF_COMPONENT_TYPE_FLOAT), also));
    }
    requireInRange(in, elements, accessor, user);
    // As they are read, and as the caller keeps them.
    budget_.charge(elements.size(), sizeof(glm::vec4) + sizeof(glm::vec3), user, "its elements");
    std::vector<glm::vec4> out(elements.size(), glm::vec4(0.0f));
    for (std::size_t k = 0; k < elements.size(); ++k) {
        const unsigned char* const data = in.element(elements[k]);
        for (int c = 0; data && c < wanted.components; ++c) {
            out[k][c] = component(data + c * in.componentBytes, in.componentType, in.normalised);
            if (!wanted.nonFiniteToo && !std::isfinite(out[k][c])) {
                fail(user, fmt::format("element {} of accessor {} is {}", elements[k], accessor,
                                       std::isnan(out[k][c]) ? "NaN" : "infinite"));
            }
        }
    }
    return out;
}

std::vector<glm::dmat4> AccessorReader::matrices(int accessor, const std::string& user) {
    const Source& in = source(accessor, user);
    if (in.components != 16 || in.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) {
        fail(user, fmt::format("accessor {} is {}; MAT4 of FLOAT is read here", accessor,
                               typeName(in.components, in.componentType)));
    }
    budget_.charge(in.count, sizeof(glm::dmat4), user, "its matrices");
    std::vector<glm::dmat4> out(in.count, glm::dmat4(0.0));
    for (std::size_t i = 0; i < in.count; ++i) {
        const unsigned char* const data = in.element(i);
        for (int c = 0; data && c < 16; ++c) {
            const float value = loaded<float>(data + c * in.componentBytes);
            if (!std::isfinite(value)) {
                fail(user, fmt::format("element {} of accessor {} is {}", i, accessor,
                                       std::isnan(value) ? "NaN" : "infinite"));
            }
            out[i][c / 4][c % 4] = value;
        }
    }
    return out;
}

std::vector<std::uint32_t> AccessorReader::indices(int accessor, std::size_t vertexCount,
                                                   const std::string& user) {
    const Source& in = source(accessor, user);
    const bool typed = in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                       in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                       in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (in.components != 1 || !typed || in.normalised) {
        fail(user, fmt::format("accessor {} is {}; indices are SCALAR of UNSIGNED_BYTE, "
                               "UNSIGNED_SHORT or UNSIGNED_INT",
                               accessor, typeName(in.components, in.componentType)));
    }
    budget_.charge(in.count, sizeof(std::uint32_t), user, "its indices");
    // The greatest value is none (glTF 2.0 specification, section 3.7.2.1): some GL would start a
    // new strip there.
    const std::uint32_t restart = 0xFFFFFFFFu >> (32 - 8 * in.componentBytes);
    std::vector<std::uint32_t> out(in.count);
    for (std::size_t i = 0; i < in.count; ++i) {
        const unsigned char* const data = in.element(i);
        out[i] = data ? unsignedAt(data, in.componentBytes) : 0;
        if (out[i] >= vertexCount) {
            fail(user, fmt::format("index {} at position {} is out of range; there are {} vertices",
                                   out[i], i, vertexCount));
        }
        if (out[i] == restart) {
            fail(user,
                 fmt::format("index {} at position {} is the primitive restart value", out[i], i));
        }
    }
    return out;
}

std::vector<glm::uvec4> AccessorReader::joints(int accessor, const std::string& user,
                                               std::span<const std::uint32_t> elements) {
    const Source& in = source(accessor, user);
    const bool typed = in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                       in.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    if (in.components != 4 || !typed || in.normalised) {
        fail(user, fmt::format("accessor {} is {}; joints are VEC4 of UNSIGNED_BYTE or "
                               "UNSIGNED_SHORT",
                               accessor, typeName(in.components, in.componentType)));
    }
    requireInRange(in, elements, accessor, user);
    budget_.charge(elements.size(), sizeof(glm::uvec4), user, "its joints");
    std::vector<glm::uvec4> out(elements.size(), glm::uvec4(0));
    for (std::size_t k = 0; k < elements.size(); ++k) {
        const unsigned char* const data = in.element(elements[k]);
        for (int c = 0; data && c < 4; ++c) {
            out[k][c] = unsignedAt(data + c * in.componentBytes, in.componentBytes);
        }
    }
    return out;
}

std::span<const unsigned char> AccessorReader::bufferView(int index,
                                                          const std::string& user) const {
    const tinygltf::BufferView& view = viewAt(index, user);
    return std::span(model_.buffers[view.buffer].data).subspan(view.byteOffset, view.byteLength);
}

}  // namespace penumbra::scene_detail
