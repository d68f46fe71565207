#include "core/passes/count_table.hpp"

#include <algorithm>

namespace penumbra {
namespace {

// As for SummedAreaTable: 256 invocations a group fill a GPU's processor, sixteen neighbouring
// columns are a few cache lines.
constexpr int kSegments = 16, kLines = 16;
constexpr int kBlockTexels = 32;

}  // namespace

CountTable CountTable::create() {
    const auto program = [](const char* pass, const char* source) {
        return gl::Program::compute(
            "common/summed_area_table_build.glsl",
            {pass, source, "TABLE_COUNTS", "SEGMENTS " + std::to_string(kSegments),
             "LINES " + std::to_string(kLines)});
    };
    CountTable table;
    table.rowsOfBits_ = program("PASS_ROWS", "SOURCE_BITS");
    table.rowsOfChannels_ = program("PASS_ROWS", "SOURCE_CHANNELS");
    table.columns_ = program("PASS_COLUMNS", "SOURCE_ROW_SUMS");
    return table;
}

void CountTable::build(const SlicePass& slices, double maxBoxTexels) {
    const bool bits = slices.targets() == SliceTargets::bits;
    const gl::Texture& source = bits ? slices.bits() : slices.channels();
    build(slices, maxBoxTexels, {glm::ivec2(0), {source.width(), source.height()}});
}

void CountTable::build(const SlicePass& slices, double maxBoxTexels, const Region& region) {
    const gl::DebugGroup group("count table");
    lanes_ = maxBoxTexels <= 65535.0 ? 2 : 1;
    const bool bits = slices.targets() == SliceTargets::bits;
    const gl::Texture& source = bits ? slices.bits() : slices.channels();
    const int layers = (std::max(slices.used(), 1) + 4 * lanes_ - 1) / (4 * lanes_);
    // Blocks, so that casters that move do not have new textures in every frame.
    const glm::ivec2 all(source.width(), source.height());
    const glm::ivec2 end =
        glm::min(all, (glm::max(region.hi, 1) + kBlockTexels - 1) / kBlockTexels * kBlockTexels);
    first_ = glm::clamp(region.lo, glm::ivec2(0), end - 1) / kBlockTexels * kBlockTexels;
    const glm::ivec2 size = end - first_;
    if (rowSums_.width() != size.x + 1 || rowSums_.height() != size.y + 1 ||
        rowSums_.layers() != layers) {
        rowSums_ = gl::Texture::createArray(GL_RGBA32UI, size.x + 1, size.y + 1, layers);
        planes_ = gl::Texture::createArray(GL_R32UI, size.x + 1, size.y + 1, 4 * layers);
        // The first row and column are nobody's sum and stay 0.
        glClearTexImage(planes_.id(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
    }
    source.bind(0);
    glBindImageTexture(0, rowSums_.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32UI);
    glBindImageTexture(2, planes_.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32UI);
    const auto groups = [](int lines) {
        return static_cast<GLuint>((lines + kLines - 1) / kLines);
    };
    const auto run = [&](const gl::Program& program, GLuint x, GLuint y) {
        program.use();
        program.set("lanes", lanes_);
        program.set("region", glm::ivec4(first_, size));
        glDispatchCompute(x, y, static_cast<GLuint>(layers));
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    };
    run(bits ? rowsOfBits_ : rowsOfChannels_, 1, groups(size.y));
    run(columns_, groups(size.x), 1);
}

void CountTable::bind(const gl::Program& program, GLuint unit) const {
    planes_.bind(unit);
    program.set("lanes", lanes_);
    program.set("table", glm::ivec4(first_, planes_.width(), planes_.height()));
}

}  // namespace penumbra
