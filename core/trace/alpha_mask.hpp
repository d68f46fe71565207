#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/scene/material.hpp"

namespace penumbra {

/// The share of a material's base colour texels whose alpha may be below its cutoff; without a
/// texture 0 or 1. Where it is 0, the material is present everywhere.
double shareCutOut(const Material& material, const std::vector<TextureImage>& images);

/// Where an alpha-masked material is present: baseColorAt(...).a >= alphaCutoff, asked for millions
/// of rays. Most of a leaf's texture is wholly there or wholly not, which one byte per texel tells;
/// baseColorAt is asked along the outline only, so that the answer is its own everywhere.
class AlphaMask {
  public:
    AlphaMask(const Material& material, const std::vector<TextureImage>& images);

    bool present(glm::vec2 uv) const;

  private:
    enum class Cell : std::uint8_t { absent, present, outline };

    const Material& material_;
    const std::vector<TextureImage>& images_;
    const TextureImage* image_ = nullptr;
    std::vector<Cell> cells_;  ///< between the centres of 2 x 2 texels
};

}  // namespace penumbra
