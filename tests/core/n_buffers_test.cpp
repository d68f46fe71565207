#include "core/passes/n_buffers.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

class NBuffersTest : public GlTest {};

constexpr int kSize = 37;  // neither a power of two nor a multiple of a work group

/// Zeros and ones in four channels, nothing in the last column and row so that a shift by one loses
/// nothing; `shift` texels to the right and down.
std::vector<glm::u8vec4> noise(int shift) {
    std::mt19937 generator(3);
    std::vector<glm::u8vec4> texels(kSize * kSize, glm::u8vec4(0));
    for (int y = 0; y + 1 < kSize; ++y)
        for (int x = 0; x + 1 < kSize; ++x) {
            glm::u8vec4& texel = texels[static_cast<std::size_t>((y + shift) * kSize + x + shift)];
            for (int c = 0; c < 4; ++c) texel[c] = generator() % 3 == 0 ? 255 : 0;
        }
    return texels;
}

gl::Texture upload(const std::vector<glm::u8vec4>& texels, int levels = 1) {
    gl::Texture texture = gl::Texture::createArray(GL_RGBA8, kSize, kSize, 2, levels);
    for (int layer = 0; layer < 2; ++layer)
        glTextureSubImage3D(texture.id(), 0, 0, 0, layer, kSize, kSize, 1, GL_RGBA,
                            GL_UNSIGNED_BYTE, texels.data());
    return texture;
}

/// One layer of an array texture.
template <class Texel>
std::vector<Texel> read(const gl::Texture& texture, int layer, GLenum format, GLenum type) {
    std::vector<Texel> texels(static_cast<std::size_t>(texture.width() * texture.height()));
    glGetTextureSubImage(texture.id(), 0, 0, 0, layer, texture.width(), texture.height(), 1, format,
                         type, static_cast<GLsizei>(texels.size() * sizeof(Texel)), texels.data());
    return texels;
}

std::vector<glm::vec4> levelOf(const NBuffers& buffers, int layer, int level) {
    return read<glm::vec4>(buffers.texture(), layer * buffers.levels() + level, GL_RGBA, GL_FLOAT);
}

TEST_F(NBuffersTest, LevelsAreMeansOfTheBoxesThatBeginThere) {
    const std::vector<glm::u8vec4> source = noise(0);
    NBuffers buffers = NBuffers::create();
    buffers.build(upload(source), 6);
    for (int level = 0; level < 6; ++level) {
        const std::vector<glm::vec4> means = levelOf(buffers, 1, level);
        const int side = 1 << level;
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                glm::vec4 sum(0.0f);
                for (int v = y; v < std::min(y + side, kSize); ++v)
                    for (int u = x; u < std::min(x + side, kSize); ++u)
                        sum += glm::vec4(source[static_cast<std::size_t>(v * kSize + u)]) / 255.0f;
                const glm::vec4 expected = sum / static_cast<float>(side * side);
                const glm::vec4 mean = means[static_cast<std::size_t>(y * kSize + x)];
                // Half floats round each level to 2^-12 of values up to 1.
                for (int c = 0; c < 4; ++c)
                    ASSERT_NEAR(mean[c], expected[c], level * 0x1p-11) << level << ' ' << x;
            }
    }
}

TEST_F(NBuffersTest, ShiftOfOneTexelShiftsEveryLevelByOne) {
    NBuffers still = NBuffers::create(), shifted = NBuffers::create();
    still.build(upload(noise(0)), 4);
    shifted.build(upload(noise(1)), 4);
    for (int level = 0; level < 4; ++level) {
        const std::vector<glm::vec4> a = levelOf(still, 0, level), b = levelOf(shifted, 0, level);
        for (int y = 0; y + 1 < kSize; ++y)
            for (int x = 0; x + 1 < kSize; ++x)
                ASSERT_EQ(b[static_cast<std::size_t>((y + 1) * kSize + x + 1)],
                          a[static_cast<std::size_t>(y * kSize + x)]);
    }
}

TEST_F(NBuffersTest, MipLevelsDoNotShift) {
    // An 8 x 8 block at a multiple of 8 fills a texel of level 3; one texel beside, 7/8 of it each
    // way.
    const auto mip = [](int shift) {
        std::vector<glm::u8vec4> texels(32 * 32, glm::u8vec4(0));
        for (int y = 8; y < 16; ++y)
            for (int x = 8; x < 16; ++x)
                texels[static_cast<std::size_t>((y + shift) * 32 + x + shift)] = glm::u8vec4(255);
        const gl::Texture texture = gl::Texture::createArray(GL_RGBA8, 32, 32, 1, 6);
        glTextureSubImage3D(texture.id(), 0, 0, 0, 0, 32, 32, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                            texels.data());
        glGenerateTextureMipmap(texture.id());
        glm::vec4 texel;
        glGetTextureSubImage(texture.id(), 3, 1, 1, 0, 1, 1, 1, GL_RGBA, GL_FLOAT, sizeof(texel),
                             &texel);
        return texel.r;
    };
    EXPECT_EQ(mip(0), 1.0f);
    // Each of three levels rounds to 1/255.
    EXPECT_NEAR(mip(1), 49.0 / 64.0, 3.0 / 255.0);
}

}  // namespace
}  // namespace penumbra
