#pragma once

#include <tiny_gltf.h>

#include <filesystem>

namespace penumbra::scene_detail {

/// Parses a .gltf or .glb into tinygltf's model. tinygltf forgives what would then be drawn wrong
/// (an index of the wrong type reads as absent) and trusts sizes; this does neither:
/// - integers, node transforms and nesting depth are checked in the JSON before it sees them;
/// - external files are read from the asset's own folder and below, nowhere else;
/// - images stay encoded (see gltf_image.hpp), so that their size is known before they are decoded;
/// - every buffer view that leaves here lies inside its buffer;
/// - whatever it complains about is an InputError of one line.
tinygltf::Model readGltf(const std::filesystem::path& file);

}  // namespace penumbra::scene_detail
