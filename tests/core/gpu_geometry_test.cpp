#include "core/frame/gpu_geometry.hpp"

#include <glad/gl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/gl/program.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

/// Positions are clip space; each instance is moved up by half the viewport; result is uv, the
/// normal's x, and 1.
constexpr const char* kShader = R"(
#ifdef STAGE_VERTEX
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec3 normal;
out vec2 fragmentUv;
out vec3 fragmentNormal;
void main() {
    fragmentUv = uv;
    fragmentNormal = normal;
    gl_Position = vec4(position + vec3(0.0, gl_InstanceID, 0.0), 1.0);
}
#endif
#ifdef STAGE_FRAGMENT
#include "common/alpha.glsl"
in vec2 fragmentUv;
in vec3 fragmentNormal;
layout(location = 0) out vec4 result;
void main() {
    if (!alphaPasses(fragmentUv)) discard;
    result = vec4(fragmentUv, fragmentNormal.x, 1.0);
}
#endif
)";

constexpr int kSize = 64;

struct Pixels {
    std::vector<glm::vec4> values;
    const glm::vec4& at(int x, int y) const {
        return values[static_cast<std::size_t>(y * kSize + x)];
    }
};

class GpuGeometryTest : public test::GlTest {
  protected:
    void SetUp() override {
        GlTest::SetUp();
        const std::filesystem::path original = gl::shaderFolder() / "common/alpha.glsl";
        std::filesystem::create_directories(folder_ / "common");
        std::filesystem::copy_file(original, folder_ / "common/alpha.glsl");
        std::ofstream(folder_ / "draw.glsl") << kShader;
        setenv("PENUMBRA_SHADERS", folder_.c_str(), 1);
        program_ = gl::Program::graphics("draw.glsl");
        unsetenv("PENUMBRA_SHADERS");
    }
    void TearDown() override {
        program_ = {};
        std::filesystem::remove_all(folder_);
        GlTest::TearDown();
    }

    Pixels draw(const GpuGeometry& geometry, bool alphaMask, int instances = 1) const {
        const gl::Texture target = gl::Texture::create2D(GL_RGBA32F, kSize, kSize);
        GLuint id = 0;
        glCreateFramebuffers(1, &id);
        const gl::Framebuffer framebuffer(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, target.id(), 0);
        glBindFramebuffer(GL_FRAMEBUFFER, id);
        glViewport(0, 0, kSize, kSize);
        const std::array<float, 4> empty = {0, 0, 0, 0};
        glClearBufferfv(GL_COLOR, 0, empty.data());
        program_.use();
        geometry.draw(program_.id(), alphaMask, instances);
        Pixels pixels{std::vector<glm::vec4>(kSize * kSize)};
        glGetTextureImage(target.id(), 0, GL_RGBA, GL_FLOAT,
                          static_cast<GLsizei>(kSize * kSize * sizeof(glm::vec4)),
                          pixels.values.data());
        return pixels;
    }

  private:
    std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                    ("penumbra_gpu_geometry_test_" + std::to_string(getpid()));
    gl::Program program_;
};

/// Adds a rectangle of clip space as a part, uv running from uvLo to uvHi.
void addRectangle(Geometry& geometry, int material, glm::vec2 lo, glm::vec2 hi,
                  glm::vec2 uvLo = {0, 0}, glm::vec2 uvHi = {1, 1}) {
    Part part;
    part.material = material;
    part.firstVertex = static_cast<std::uint32_t>(geometry.positions.size());
    part.vertexCount = 4;
    part.firstIndex = static_cast<std::uint32_t>(geometry.indices.size());
    part.indexCount = 6;
    for (const glm::vec2 corner :
         {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        geometry.positions.emplace_back(glm::mix(lo, hi, corner), 0.5f);
        geometry.uvs.push_back(glm::mix(uvLo, uvHi, corner));
        geometry.normals.emplace_back(0.25f, 0.0f, 1.0f);
    }
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u})
        geometry.indices.push_back(part.firstVertex + i);
    geometry.parts.push_back(part);
}

TEST_F(GpuGeometryTest, MaskedMaterialsAreTestedEachWithItsOwnAlpha) {
    std::vector<Material> materials(3);
    materials[0].masked = true;  // below its cutoff: nowhere
    materials[0].baseColor.a = 0.4f;
    materials[2].masked = true;  // at its cutoff: everywhere
    materials[2].baseColor.a = 0.25f;
    materials[2].alphaCutoff = 0.25f;
    const std::vector<TextureImage> noImages;
    const GpuMaterials gpuMaterials(materials, noImages);

    // Columns of the image, masked and opaque parts in turn, so that batches must re-order them.
    auto geometry = std::make_shared<Geometry>();
    const std::array<int, 5> columns = {0, 1, 2, 1, 0};
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const float left = -1.0f + 0.4f * static_cast<float>(i);
        addRectangle(*geometry, columns[i], {left, -1}, {left + 0.4f, 1});
    }
    const GpuGeometry gpuGeometry(geometry, gpuMaterials);

    const Pixels masked = draw(gpuGeometry, true), opaque = draw(gpuGeometry, false);
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const int x = static_cast<int>(kSize * (0.1 + 0.2 * static_cast<double>(i)));
        EXPECT_EQ(masked.at(x, kSize / 2).w, columns[i] == 0 ? 0.0f : 1.0f) << "column " << i;
        EXPECT_EQ(opaque.at(x, kSize / 2).w, 1.0f) << "column " << i;
        EXPECT_EQ(opaque.at(x, kSize / 2).z, 0.25f) << "the normal is attribute 2";
    }
}

TEST_F(GpuGeometryTest, InstancesAreDrawnInOneCallEach) {
    const std::vector<Material> materials(1);
    const std::vector<TextureImage> noImages;
    const GpuMaterials gpuMaterials(materials, noImages);
    auto geometry = std::make_shared<Geometry>();
    addRectangle(*geometry, 0, {-1, -1}, {1, 0});
    const GpuGeometry gpuGeometry(geometry, gpuMaterials);
    EXPECT_EQ(draw(gpuGeometry, true, 1).at(5, kSize - 5).w, 0.0f);
    EXPECT_EQ(draw(gpuGeometry, true, 2).at(5, kSize - 5).w, 1.0f);
    EXPECT_EQ(draw(gpuGeometry, false, 2).at(5, kSize - 5).w, 1.0f);
}

TEST_F(GpuGeometryTest, NothingToDrawIsNoError) {
    const std::vector<Material> materials(1);
    const std::vector<TextureImage> noImages;
    const GpuMaterials gpuMaterials(materials, noImages);
    const GpuGeometry gpuGeometry(std::make_shared<Geometry>(), gpuMaterials);
    EXPECT_EQ(draw(gpuGeometry, true).at(0, 0).w, 0.0f);
    EXPECT_EQ(draw(gpuGeometry, false).at(0, 0).w, 0.0f);
}

/// Random alpha, every wrap mode and both filters: what the GPU draws is what the CPU's rule says.
TEST_F(GpuGeometryTest, AlphaRuleIsTheSameOnCpuAndGpu) {
    for (const bool linear : {false, true}) {
        for (const Wrap wrapS : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge}) {
            for (const Wrap wrapT : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge}) {
                TextureImage image;
                image.width = 8;
                image.height = 4;
                image.wrapS = wrapS;
                image.wrapT = wrapT;
                image.linear = linear;
                std::mt19937 random(7);
                for (int i = 0; i < 4 * image.width * image.height; ++i)
                    image.rgba.push_back(static_cast<std::uint8_t>(random() & 255));
                Material material;
                material.masked = true;
                material.baseColorTexture = 0;
                material.baseColor.a = 0.875f;
                material.alphaCutoff = 0.4f;
                const std::vector<Material> materials = {material};
                const std::vector<TextureImage> images = {image};
                const GpuMaterials gpuMaterials(materials, images);

                // 64 pixels over 4 units: uv lies half a sixteenth from every texel's edge.
                const glm::vec2 uvLo(-1.5f), uvHi(2.5f);
                auto geometry = std::make_shared<Geometry>();
                addRectangle(*geometry, 0, {-1, -1}, {1, 1}, uvLo, uvHi);
                const Pixels drawn = draw(GpuGeometry(geometry, gpuMaterials), true);

                // GPUs filter with weights of 8 bits: in each direction alpha is off by up to
                // 1/512.
                const float tolerance = linear ? 2.0f / 512 : 1e-6f;
                int passed = 0, failed = 0;
                for (int y = 0; y < kSize; ++y) {
                    for (int x = 0; x < kSize; ++x) {
                        const glm::vec2 uv =
                            uvLo + (uvHi - uvLo) * (glm::vec2(x, y) + 0.5f) / float(kSize);
                        const float alpha = baseColorAt(material, images, uv).a;
                        if (std::abs(alpha - material.alphaCutoff) <= tolerance) continue;
                        const bool passes = alpha >= material.alphaCutoff;
                        (passes ? passed : failed)++;
                        ASSERT_EQ(drawn.at(x, y).w == 1.0f, passes)
                            << "pixel " << x << ' ' << y << ", linear " << linear << ", wrap "
                            << int(wrapS) << ' ' << int(wrapT) << ", alpha " << alpha;
                    }
                }
                // Chosen so that either outcome is common.
                EXPECT_GT(passed, kSize * kSize / 5);
                EXPECT_GT(failed, kSize * kSize / 5);
            }
        }
    }
}

}  // namespace
}  // namespace penumbra
