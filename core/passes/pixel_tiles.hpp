#pragma once

#include "core/frame/frame.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Answers tiles of 8 x 8 pixels at once where that is possible and shades only the others. A first
/// program says per tile what is known of all of its receivers; a second one runs on the pixels of
/// the tiles for which that was not enough; a last one puts both together. shaders/common/
/// pixel_tiles.glsl has the GLSL side.
///
/// What a tile holds is one float: 0 where its receivers are lit, negative where they are dark,
/// positive, and the method's own, where its pixels are to be shaded; and four more floats of the
/// method's own for these.
class PixelTiles {
  public:
    PixelTiles() = default;
    /// Compiles; textures are allocated by classify.
    static PixelTiles create();

    /// Runs `program` (a fragment per tile, a float and a vec4 out) over the tiles of `frame`'s
    /// pixels. Like the passes below it takes the program in use and binds the G-buffer and the
    /// textures it reads, and sets all GL state it needs.
    void classify(const gl::Program& program, const Frame& frame);
    /// Runs `program` (TILE_POINTS defined) over the pixels of undecided tiles.
    void shade(const gl::Program& program, const Frame& frame) const;
    /// The program that writes the answers, in use and with what it reads bound, for
    /// VisibilityTarget::draw.
    const gl::Program& answers() const;

    double mebibytes() const {
        return tiles_.mebibytes() + notes_.mebibytes() + pixels_.mebibytes();
    }

  private:
    void begin(const gl::Framebuffer& framebuffer, const Frame& frame) const;

    gl::Program answers_;
    gl::Texture tiles_, notes_, pixels_;
    gl::Framebuffer tileBuffer_, pixelBuffer_;
    gl::VertexArray empty_;
};

}  // namespace penumbra
