#include "core/passes/fill_depths.hpp"

#include <algorithm>
#include <limits>

namespace penumbra {

FillDepths::FillDepths(const Geometry& geometry) : casters_(Casters::find(geometry)) {}

SliceFill FillDepths::find(const Geometry& geometry, const SliceView& view, Bodies filled) {
    const std::vector<glm::vec3>& positions = geometry.positions;
    if (casters_.ofVertex.size() != positions.size()) casters_ = Casters::find(geometry);
    struct Extent {
        float nearM = std::numeric_limits<float>::max(), deepestM = 0.0f;
    };
    std::vector<Extent> bodies(casters_.thicknessM.size());
    const glm::vec3 axis(view.axisZ), centre(view.centre);
    for (std::size_t v = 0; v < positions.size(); ++v) {
        Extent& body = bodies[casters_.ofVertex[v]];
        const float depthM = glm::dot(axis, positions[v] - centre);
        body.nearM = std::min(body.nearM, depthM);
        body.deepestM = std::max(body.deepestM, depthM);
    }
    const double sliceM =
        (view.farM - view.boundariesM[0]) / (static_cast<double>(view.planesM.size()) + 1.0);
    filled_ = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        Extent& body = bodies[b];
        if (filled == Bodies::thinnerThanASlice && casters_.thicknessM[b] >= sliceM)
            body.deepestM = 0.0f;
        filled_ |= slicesBegunBetween(view, body.nearM, body.deepestM);
    }
    if (filled_ == 0) return {};
    constexpr std::size_t kWidth = 4096;
    const std::size_t rows = std::max<std::size_t>(1, (positions.size() + kWidth - 1) / kWidth);
    std::vector<float> depths(rows * kWidth, 0.0f);
    for (std::size_t v = 0; v < positions.size(); ++v)
        depths[v] = bodies[casters_.ofVertex[v]].deepestM;
    if (depths_.height() != static_cast<int>(rows))
        depths_ = gl::Texture::create2D(GL_R32F, static_cast<int>(kWidth), static_cast<int>(rows));
    glTextureSubImage2D(depths_.id(), 0, 0, 0, static_cast<GLsizei>(kWidth),
                        static_cast<GLsizei>(rows), GL_RED, GL_FLOAT, depths.data());
    return {.always = false, .depthM = &depths_};
}

}  // namespace penumbra
