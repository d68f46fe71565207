#include "harness/viewer/texture_preview.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace penumbra {
namespace {

struct FormatInfo {
    GLenum format;
    const char* name;
    GLenum components;  ///< to read it with
    int channels;
    bool integer;
};
constexpr FormatInfo kFormats[] = {
    {GL_R8, "R8", GL_RED, 1, false},
    {GL_R16, "R16", GL_RED, 1, false},
    {GL_R16F, "R16F", GL_RED, 1, false},
    {GL_R32F, "R32F", GL_RED, 1, false},
    {GL_RG8, "RG8", GL_RG, 2, false},
    {GL_RG16, "RG16", GL_RG, 2, false},
    {GL_RG16F, "RG16F", GL_RG, 2, false},
    {GL_RG32F, "RG32F", GL_RG, 2, false},
    {GL_RGBA8, "RGBA8", GL_RGBA, 4, false},
    {GL_RGBA16, "RGBA16", GL_RGBA, 4, false},
    {GL_RGBA16F, "RGBA16F", GL_RGBA, 4, false},
    {GL_RGBA32F, "RGBA32F", GL_RGBA, 4, false},
    {GL_RGB10_A2, "RGB10_A2", GL_RGBA, 4, false},
    {GL_R11F_G11F_B10F, "R11F_G11F_B10F", GL_RGB, 3, false},
    {GL_R8UI, "R8UI", GL_RED_INTEGER, 1, true},
    {GL_R16UI, "R16UI", GL_RED_INTEGER, 1, true},
    {GL_R32UI, "R32UI", GL_RED_INTEGER, 1, true},
    {GL_R32I, "R32I", GL_RED_INTEGER, 1, true},
    {GL_RG16UI, "RG16UI", GL_RG_INTEGER, 2, true},
    {GL_RG32UI, "RG32UI", GL_RG_INTEGER, 2, true},
    {GL_RG32I, "RG32I", GL_RG_INTEGER, 2, true},
    {GL_RGBA16UI, "RGBA16UI", GL_RGBA_INTEGER, 4, true},
    {GL_RGBA32UI, "RGBA32UI", GL_RGBA_INTEGER, 4, true},
    {GL_RGBA32I, "RGBA32I", GL_RGBA_INTEGER, 4, true},
    {GL_DEPTH_COMPONENT16, "DEPTH16", GL_DEPTH_COMPONENT, 1, false},
    {GL_DEPTH_COMPONENT24, "DEPTH24", GL_DEPTH_COMPONENT, 1, false},
    {GL_DEPTH_COMPONENT32F, "DEPTH32F", GL_DEPTH_COMPONENT, 1, false},
};

const FormatInfo& infoOf(GLenum format) {
    for (const FormatInfo& info : kFormats)
        if (info.format == format) return info;
    throw std::runtime_error("a texture of this format cannot be shown");
}

std::vector<float> readAll(const gl::Texture& texture, const FormatInfo& info, int layer) {
    const std::size_t count =
        static_cast<std::size_t>(texture.width()) * texture.height() * info.channels;
    std::vector<float> values(count);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    const auto read = [&](GLenum type, void* data) {
        glGetTextureSubImage(texture.id(), 0, 0, 0, layer, texture.width(), texture.height(), 1,
                             info.components, type, static_cast<GLsizei>(count * sizeof(float)),
                             data);
    };
    if (!info.integer) {
        read(GL_FLOAT, values.data());
        return values;
    }
    std::vector<GLuint> integers(count);
    read(GL_UNSIGNED_INT, integers.data());
    std::ranges::transform(integers, values.begin(),
                           [](GLuint v) { return static_cast<float>(v); });
    return values;
}

}  // namespace

int channelsOf(const gl::Texture& texture) {
    return infoOf(texture.format()).channels;
}

std::string formatName(const NamedTexture& texture) {
    return texture.texture ? infoOf(texture.texture->format()).name : "picture";
}

TextureLayer readLayer(const NamedTexture& texture, int layer, int channel, int most) {
    TextureLayer out;
    std::vector<float> all;
    if (texture.texture) {
        const FormatInfo& info = infoOf(texture.texture->format());
        out.fullWidth = texture.texture->width();
        out.fullHeight = texture.texture->height();
        out.layers = std::max(1, texture.texture->layers());
        out.channels = info.channels;
        all = readAll(*texture.texture, info, std::clamp(layer, 0, out.layers - 1));
    } else {
        out.fullWidth = texture.picture->width;
        out.fullHeight = texture.picture->height;
        out.channels = static_cast<int>(texture.picture->channelCount());
        all = texture.picture->pixels;
    }
    const int stride = std::max(1, (std::max(out.fullWidth, out.fullHeight) + most - 1) / most);
    out.width = (out.fullWidth + stride - 1) / stride;
    out.height = (out.fullHeight + stride - 1) / stride;
    for (int y = 0; y < out.fullHeight; y += stride)
        for (int x = 0; x < out.fullWidth; x += stride) {
            const float* texel =
                &all[(static_cast<std::size_t>(y) * out.fullWidth + x) * out.channels];
            out.values.insert(out.values.end(), texel, texel + out.channels);
        }
    channel = std::clamp(channel, 0, out.channels - 1);
    out.lo = std::numeric_limits<float>::infinity();
    out.hi = -out.lo;
    for (std::size_t i = static_cast<std::size_t>(channel); i < out.values.size();
         i += static_cast<std::size_t>(out.channels)) {
        if (!std::isfinite(out.values[i])) continue;
        out.lo = std::min(out.lo, out.values[i]);
        out.hi = std::max(out.hi, out.values[i]);
    }
    if (out.lo > out.hi) out.lo = out.hi = 0.0f;
    return out;
}

Image greyPicture(const TextureLayer& layer, int channel, float lo, float hi, bool topFirst) {
    Image image = Image::withChannels(layer.width, layer.height, {"R", "G", "B"});
    channel = std::clamp(channel, 0, layer.channels - 1);
    const float scale = hi > lo ? 1.0f / (hi - lo) : 0.0f;
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x) {
            const int from = topFirst ? y : layer.height - 1 - y;
            const float value =
                layer.values[(static_cast<std::size_t>(from) * layer.width + x) * layer.channels +
                             channel];
            const bool finite = std::isfinite(value);
            // Squared: near enough to even steps for the eye once it is sRGB encoded.
            const float shade = std::clamp((value - lo) * scale, 0.0f, 1.0f);
            image.at(x, y, 0) = image.at(x, y, 2) = finite ? shade * shade : 1.0f;
            image.at(x, y, 1) = finite ? shade * shade : 0.0f;
        }
    return image;
}

}  // namespace penumbra
