#pragma once

#include <string>
#include <vector>

#include "harness/viewer/picture.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {

/// One layer of a method's texture, read back for people to look at.
struct TextureLayer {
    int width = 0, height = 0;  ///< of what is kept: every `stride`-th texel
    int fullWidth = 0, fullHeight = 0;
    int layers = 1, channels = 1;
    std::vector<float> values;   ///< width * height * channels, row 0 the texture's first
    float lo = 0.0f, hi = 0.0f;  ///< least and greatest finite value of the chosen channel
};

/// Reads layer `layer` (below max(1, layers)) of a texture, thinned to at most `most` texels
/// across. `channel` is what lo and hi are of.
TextureLayer readLayer(const NamedTexture& texture, int layer, int channel, int most = 512);

/// A channel as grey from black at `lo` to white at `hi`, non-finite values magenta; the image's
/// top row is the layer's last, as a shadow map is thought of, unless `topFirst`.
Image greyPicture(const TextureLayer& layer, int channel, float lo, float hi, bool topFirst);

/// Of a texel, 1 to 4.
int channelsOf(const gl::Texture& texture);

/// "R32F", "DEPTH32F", ...; "picture" for a made picture.
std::string formatName(const NamedTexture& texture);

}  // namespace penumbra
