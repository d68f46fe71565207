#include "core/scene/supported_input.hpp"

#include <algorithm>
#include <array>

namespace penumbra {
namespace {

using enum SupportedInput::Kind;

constexpr std::array kTable = {
    SupportedInput{"KHR_lights_punctual", read,
                   "without an emissive rectangle the brightest point or spot light is a point "
                   "light at its place, else the brightest directional one, 100 radii away"},
    SupportedInput{"KHR_materials_emissive_strength", read,
                   "factor of a rectangle's flux, which decides between several"},
    SupportedInput{"KHR_texture_transform", read,
                   "of base colour textures: coordinates and their set"},
    SupportedInput{"KHR_mesh_quantization", read,
                   "integer positions, normals and coordinates, normalised or not"},
    SupportedInput{"EXT_mesh_gpu_instancing", read,
                   "TRANSLATION, ROTATION and SCALE of instances, not of skinned meshes"},

    SupportedInput{"KHR_materials_anisotropy", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_clearcoat", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_diffuse_transmission", ignored, "surfaces stay opaque"},
    SupportedInput{"KHR_materials_dispersion", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_ior", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_iridescence", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_sheen", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_specular", ignored, "changes no shadow"},
    SupportedInput{"KHR_materials_transmission", ignored, "surfaces stay opaque"},
    SupportedInput{"KHR_materials_unlit", ignored, "surfaces are lit all the same"},
    SupportedInput{"KHR_materials_variants", ignored, "the default variant is used"},
    SupportedInput{"KHR_materials_volume", ignored, "surfaces stay opaque"},
    SupportedInput{"KHR_xmp_json_ld", ignored, "metadata"},

    SupportedInput{"KHR_draco_mesh_compression", refused, "vertices are compressed"},
    SupportedInput{"EXT_meshopt_compression", refused, "buffers are compressed"},
    SupportedInput{"KHR_meshopt_compression", refused, "buffers are compressed"},
    SupportedInput{"KHR_texture_basisu", refused, "textures are in KTX 2"},
    SupportedInput{"EXT_texture_webp", refused, "textures are in WebP"},
    SupportedInput{"EXT_texture_avif", refused, "textures are in AVIF"},
    SupportedInput{"MSFT_texture_dds", refused, "textures are in DDS"},
    SupportedInput{"KHR_materials_pbrSpecularGlossiness", refused,
                   "base colour and alpha are elsewhere; ignored where it is optional"},
    SupportedInput{"KHR_techniques_webgl", refused, "materials are GLSL"},
    SupportedInput{"KHR_animation_pointer", refused, "animates by JSON pointer"},
    SupportedInput{"KHR_node_visibility", refused, "hides nodes"},
    SupportedInput{"MSFT_lod", refused, "several levels of detail"},

    SupportedInput{"max_memory", limit,
                   "4 GiB unless --max-memory is given: the sum of all that an asset makes the "
                   "loader allocate, "
                   "asked before it is allocated"},
    SupportedInput{"json_nesting", limit, "100 levels"},
    SupportedInput{"whole_numbers", limit,
                   "indices, counts and offsets: whole numbers from 0 to 2147483647"},
    SupportedInput{"triangles", limit, "100 million in all places of a scene"},
    SupportedInput{"image", limit,
                   "268435456 texels (16384 x 16384), PNG or JPEG by content; 100 scans of a "
                   "progressive JPEG"},
    SupportedInput{
        "extent", limit,
        "1e15 m from the origin, of vertices in every frame, lights and cameras; 1e15 of "
        "texture coordinates and of every number in a script"},
    SupportedInput{"frames", limit, "10000 in a script"},
    SupportedInput{"script", limit,
                   "16 MiB, values 256 deep, 16 dots in a line besides decimal points"},
};

}  // namespace

std::string_view SupportedInput::kindName() const {
    static constexpr std::array<std::string_view, 4> kNames = {"read", "ignored", "refused",
                                                               "limit"};
    return kNames[static_cast<std::size_t>(kind)];
}

std::span<const SupportedInput> supportedInputs() {
    return kTable;
}

const SupportedInput* findExtension(std::string_view name) {
    const auto found = std::find_if(kTable.begin(), kTable.end(), [&](const SupportedInput& each) {
        return each.kind != limit && each.id == name;
    });
    return found == kTable.end() ? nullptr : &*found;
}

}  // namespace penumbra
