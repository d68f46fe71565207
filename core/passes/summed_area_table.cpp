#include "core/passes/summed_area_table.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

// 256 invocations a group fill a GPU's processor; sixteen neighbouring columns are a cache line or
// two, and sixteen pieces a line keep the shared sums short. Measured best on llvmpipe, too.
constexpr int kSegments = 16, kLines = 16;

GLuint groups(int items, int perGroup) {
    return static_cast<GLuint>((items + perGroup - 1) / perGroup);
}

}  // namespace

SummedAreaTable SummedAreaTable::create(Kind kind) {
    SummedAreaTable table;
    table.kind_ = kind;
    const auto program = [&](const char* pass) {
        std::vector<std::string> defines = {pass, "SEGMENTS " + std::to_string(kSegments),
                                            "LINES " + std::to_string(kLines)};
        if (kind == Kind::uint32) defines.emplace_back("TABLE_UINT");
        if (kind == Kind::float32) defines.emplace_back("SUBTRACT_MEAN");
        return gl::Program::compute("common/summed_area_table_build.glsl", defines);
    };
    table.rows_ = program("PASS_ROWS");
    table.columns_ = program("PASS_COLUMNS");
    if (kind == Kind::float32) {
        table.rowMeans_ = program("PASS_ROW_MEANS");
        table.mean_ = program("PASS_MEAN");
    }
    return table;
}

void SummedAreaTable::build(const gl::Texture& source, double maxBoxTexels) {
    const gl::DebugGroup group("summed-area table");
    const int width = source.width(), height = source.height(), layers = source.layers();
    if (table_.width() != width + 1 || table_.height() != height + 1 || table_.layers() != layers) {
        table_ = gl::Texture::createArray(format(), width + 1, height + 1, layers);
        means_ = gl::Texture::createArray(GL_RG32F, 1, height + 1, layers);
        // The first row and column are nobody's sum and stay 0.
        if (integer())
            glClearTexImage(table_.id(), 0, GL_RG_INTEGER, GL_UNSIGNED_INT, nullptr);
        else
            glClearTexImage(table_.id(), 0, GL_RG, GL_FLOAT, nullptr);
        glClearTexImage(means_.id(), 0, GL_RG, GL_FLOAT, nullptr);
    }
    const double texels = static_cast<double>(width) * height;
    maxBoxTexels_ = integer() ? std::clamp(maxBoxTexels, 1.0, texels) : texels;
    stepsPerUnit_ = integer() ? 2.0 / stepOf(maxBoxTexels_) : 0.0;
    source.bind(0);
    glBindImageTexture(0, table_.id(), 0, GL_TRUE, 0, GL_READ_WRITE, table_.format());
    glBindImageTexture(1, means_.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RG32F);
    const auto run = [&](const gl::Program& program, GLuint x, GLuint y) {
        program.use();
        program.set("stepsPerUnit", static_cast<float>(stepsPerUnit_));
        glDispatchCompute(x, y, static_cast<GLuint>(layers));
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    };
    if (kind_ == Kind::float32) {
        run(rowMeans_, groups(height, 8), 1);
        run(mean_, 1, 1);
    }
    run(rows_, 1, groups(height, kLines));
    run(columns_, groups(width, kLines), 1);
}

GLenum SummedAreaTable::format() const {
    return integer() ? GL_RG32UI : GL_RG32F;
}

double SummedAreaTable::stepOf(double maxBoxTexels) {
    // As many steps from -1 to 1 as a box full of ones can add up without wrapping; the shader's
    // float of that number may be the next one above it.
    return 2.0 / std::floor(4294967295.0 / maxBoxTexels * (1.0 - 0x1p-23));
}

double SummedAreaTable::stepError() const {
    return integer() && stepsPerUnit_ > 0.0 ? 1.0 / stepsPerUnit_ : 0.0;
}

double SummedAreaTable::sumError() const {
    return integer() ? 0.0 : 0x1p-24 * table_.width() * table_.height() / 8.0;
}

double SummedAreaTable::mebibytes() const {
    return table_.mebibytes() + means_.mebibytes();
}

void SummedAreaTable::bind(const gl::Program& program, GLuint unit) const {
    table_.bind(unit);
    means_.bind(unit + 1);
    program.set("tableStepsPerUnit", static_cast<float>(stepsPerUnit_));
    program.set("tableMaxBox", static_cast<float>(maxBoxTexels_));
}

}  // namespace penumbra
