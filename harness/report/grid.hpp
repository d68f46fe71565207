#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/reference.hpp"
#include "harness/run/row.hpp"

namespace penumbra {

struct GridCell {
    const Row* row = nullptr;       ///< never null
    std::vector<float> visibility;  ///< empty if the row has no image; else one entry per pixel
};

struct GridFrame {
    int index = 0;
    const GBuffer* gbuffer = nullptr;      ///< never null
    const Reference* reference = nullptr;  ///< never null, of the G-buffer's size
    std::vector<GridCell> cells;           ///< in the order of the columns
};

/// As a PNG has it: three bytes a pixel, sRGB, top row first.
struct GridPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

/// grid/<scene>.png: one picture of a scene for people. Columns are the reference and then the
/// cells; each is a shaded image over its signed error map (under the reference: its pixel classes)
/// with name, rmse, frame time and the effects that the method cannot simulate below; a cell
/// without an image says why. Frames stack downwards. Tiles are 384 pixels wide up to 6 columns,
/// else 256; after 12 columns a new line starts.
GridPicture renderGrid(const std::string& sceneId, const std::string& shows,
                       const std::vector<GridFrame>& frames);

}  // namespace penumbra
