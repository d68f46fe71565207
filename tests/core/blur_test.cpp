#include "core/passes/blur.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <glm/glm.hpp>
#include <random>

#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

class BlurTest : public GlTest {};

constexpr int kWidth = 23, kHeight = 17, kLayers = 2;
using Texels = std::vector<glm::vec2>;

Texels noise() {
    std::mt19937 generator(1);
    std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
    Texels texels(std::size_t{kWidth} * kHeight * kLayers);
    for (glm::vec2& t : texels) t = {uniform(generator), uniform(generator)};
    return texels;
}

Texels blurred(const Texels& texels, const std::vector<float>& x, const std::vector<float>& y) {
    const gl::Texture texture = gl::Texture::createArray(GL_RG32F, kWidth, kHeight, kLayers);
    glTextureSubImage3D(texture.id(), 0, 0, 0, 0, kWidth, kHeight, kLayers, GL_RG, GL_FLOAT,
                        texels.data());
    Blur blur = Blur::create();
    blur.apply(texture, x, y);
    Texels result(texels.size());
    glGetTextureImage(texture.id(), 0, GL_RG, GL_FLOAT,
                      static_cast<GLsizei>(result.size() * sizeof(glm::vec2)), result.data());
    return result;
}

double weightAt(const std::vector<float>& weights, int distance) {
    const auto i = static_cast<std::size_t>(std::abs(distance));
    return i < weights.size() ? static_cast<double>(weights[i]) : 0.0;
}

TEST(BlurWeights, AddUpToOneAndHaveTheBoxesVariance) {
    for (const double width : {1.5, 2.0, 3.0, 4.7, 9.0, 32.4})
        for (const BlurShape shape : {BlurShape::box, BlurShape::gaussian}) {
            const std::vector<float> weights = blurWeights(shape, width);
            double sum = 0.0, variance = 0.0;
            const int reach = static_cast<int>(weights.size()) - 1;
            for (int i = -reach; i <= reach; ++i) {
                sum += weightAt(weights, i);
                variance += weightAt(weights, i) * i * i;
            }
            EXPECT_NEAR(sum, 1.0, 1e-6) << width;
            EXPECT_GE(*std::ranges::min_element(weights), 0.0f);
            // A box's parts of its outermost texels count at those texels' centres: 1/6 too much
            // where it ends halfway. A Gaussian cut at three deviations loses 2.7 % of it.
            EXPECT_NEAR(variance, width * width / 12.0, 0.1667 + 0.027 * width * width / 12.0)
                << width;
        }
}

TEST(BlurWeights, OfATexelAndLessChangeNothing) {
    for (const double width : {0.0, 0.3, 1.0})
        for (const BlurShape shape : {BlurShape::box, BlurShape::gaussian})
            EXPECT_EQ(blurWeights(shape, width), std::vector<float>{1.0f});
}

TEST(BlurWeights, OfABoxCountTheOutermostTexelsByTheirPart) {
    // 2.5 texels: the middle one and three quarters of each neighbour.
    const std::vector<float> weights = blurWeights(BlurShape::box, 2.5);
    ASSERT_EQ(weights.size(), 2u);
    EXPECT_FLOAT_EQ(weights[0], 0.4f);
    EXPECT_FLOAT_EQ(weights[1], 0.3f);
}

TEST_F(BlurTest, EqualsBruteForceAtBordersToo) {
    const Texels texels = noise();
    const std::vector<float> x = blurWeights(BlurShape::gaussian, 7.3);
    const std::vector<float> y = blurWeights(BlurShape::box, 4.0);
    const Texels result = blurred(texels, x, y);
    for (int layer = 0; layer < kLayers; ++layer)
        for (int j = 0; j < kHeight; ++j)
            for (int i = 0; i < kWidth; ++i) {
                glm::dvec2 sum(0.0);
                double within = 0.0;
                for (int v = 0; v < kHeight; ++v)
                    for (int u = 0; u < kWidth; ++u) {
                        const double w = weightAt(x, u - i) * weightAt(y, v - j);
                        sum += w * glm::dvec2(texels[static_cast<std::size_t>(
                                       (layer * kHeight + v) * kWidth + u)]);
                        within += w;
                    }
                const glm::dvec2 got(
                    result[static_cast<std::size_t>((layer * kHeight + j) * kWidth + i)]);
                // Two sums of up to 20 floats of magnitude 1.
                ASSERT_NEAR(got.x, sum.x / within, 2e-6) << i << ", " << j << ", " << layer;
                ASSERT_NEAR(got.y, sum.y / within, 2e-6) << i << ", " << j << ", " << layer;
            }
}

TEST_F(BlurTest, LeavesAConstantAlone) {
    const Texels texels(noise().size(), {0.7f, -0.3f});
    const std::vector<float> wide = blurWeights(BlurShape::box, 101.0);
    for (const glm::vec2& t : blurred(texels, wide, wide)) {
        ASSERT_NEAR(t.x, 0.7f, 2e-6f);
        ASSERT_NEAR(t.y, -0.3f, 2e-6f);
    }
}

TEST_F(BlurTest, OfOneTexelIsTheIdentity) {
    const Texels texels = noise();
    EXPECT_EQ(blurred(texels, {1.0f}, {1.0f}), texels);
}

}  // namespace
}  // namespace penumbra
