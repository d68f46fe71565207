#include "core/passes/blur.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

std::vector<float> blurWeights(BlurShape shape, double widthTexels) {
    const double half = 0.5 * std::max(widthTexels, 1.0);
    const double sigma = half / std::sqrt(3.0);
    const bool box = shape == BlurShape::box || half == 0.5;
    const auto reach = static_cast<int>(std::ceil(box ? half - 0.5 : 3.0 * sigma));
    std::vector<double> weights;
    double sum = 0.0;
    for (int i = 0; i <= reach; ++i) {
        weights.push_back(box ? std::min(half + 0.5 - i, 1.0)
                              : std::exp(-0.5 * i * i / sigma / sigma));
        sum += (i == 0 ? 1.0 : 2.0) * weights.back();
    }
    std::vector<float> result;
    for (const double weight : weights) result.push_back(static_cast<float>(weight / sum));
    return result;
}

Blur Blur::create() {
    Blur blur;
    blur.pass_ = LayerPass::create();
    blur.program_ = gl::Program::graphics("common/blur.glsl");
    return blur;
}

void Blur::apply(const gl::Texture& texture, const std::vector<float>& weightsX,
                 const std::vector<float>& weightsY) {
    const gl::DebugGroup group("blur");
    if (scratch_.format() != texture.format() || scratch_.width() != texture.width() ||
        scratch_.height() != texture.height() || scratch_.layers() != texture.layers())
        scratch_ = gl::Texture::createArray(texture.format(), texture.width(), texture.height(),
                                            texture.layers());
    along(1, 0, weightsX, texture, scratch_);
    along(0, 1, weightsY, scratch_, texture);
}

void Blur::along(int x, int y, const std::vector<float>& weights, const gl::Texture& from,
                 const gl::Texture& to) const {
    const gl::Buffer buffer = gl::Buffer::create(weights.size() * sizeof(float), weights.data());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    from.bind(0);
    program_.set("stepX", x);
    program_.set("stepY", y);
    program_.set("reach", static_cast<int>(weights.size()) - 1);
    for (int layer = 0; layer < to.layers(); ++layer) {
        program_.set("layer", layer);
        pass_.draw(program_, to, layer);
    }
}

}  // namespace penumbra
