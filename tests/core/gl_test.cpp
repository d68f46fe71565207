#include <glad/gl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>

#include "core/error.hpp"
#include "core/gl/context.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/gl/shader_source.hpp"
#include "core/parameter/parameter.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra::gl {
namespace {

using test::GlTest;

/// A shader folder of its own for as long as it lives.
class ShaderFolder {
  public:
    ShaderFolder() {
        std::filesystem::create_directories(folder_ / "common");
        setenv("PENUMBRA_SHADERS", folder_.c_str(), 1);
    }
    ~ShaderFolder() {
        unsetenv("PENUMBRA_SHADERS");
        std::filesystem::remove_all(folder_);
    }
    void write(const std::string& file, const std::string& text) const {
        std::ofstream(folder_ / file) << text;
    }

  private:
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("penumbra_gl_test_" + std::to_string(getpid()));
};

/// A vertex stage that covers the viewport, and the start of a fragment stage with one output.
const std::string kFullScreen = R"(#ifdef STAGE_VERTEX
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.5, 1.0);
}
#endif
)";

std::string fragment(const std::string& body) {
    return kFullScreen + "#ifdef STAGE_FRAGMENT\nlayout(location = 0) out vec4 result;\n" + body +
           "#endif\n";
}

/// The single pixel that `program` draws.
std::array<float, 4> drawPixel(const Program& program) {
    const Texture target = Texture::create2D(GL_RGBA32F, 1, 1);
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    const Framebuffer framebuffer(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, target.id(), 0);
    glCreateVertexArrays(1, &id);
    const VertexArray noAttributes(id);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    glViewport(0, 0, 1, 1);
    glBindVertexArray(noAttributes.id());
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    std::array<float, 4> pixel{};
    glGetTextureImage(target.id(), 0, GL_RGBA, GL_FLOAT, sizeof pixel, pixel.data());
    return pixel;
}

template <class Error, class Action>
std::string messageOf(Action action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(ContextKind, IsParsedAndNamesTheChoices) {
    EXPECT_EQ(parseContextKind("osmesa"), ContextKind::osmesa);
    EXPECT_EQ(parseContextKind("egl"), ContextKind::egl);
    EXPECT_EQ(parseContextKind("glfw"), ContextKind::glfw);
    EXPECT_EQ(parseContextKind("auto"), ContextKind::automatic);
    EXPECT_EQ(messageOf<InputError>([] { parseContextKind("vulkan"); }),
              "unknown context 'vulkan'; the contexts are osmesa, egl, glfw, auto");
}

TEST_F(GlTest, OsmesaGivesCoreProfile45) {
    const Context& context = test::glContext();
    EXPECT_EQ(context.kind(), ContextKind::osmesa);
    EXPECT_TRUE(contains(context.renderer(), "llvmpipe")) << context.renderer();
    GLint major = 0, minor = 0, profile = 0;
    glGetIntegerv(GL_MAJOR_VERSION, &major);
    glGetIntegerv(GL_MINOR_VERSION, &minor);
    glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    EXPECT_GE(10 * major + minor, 45);
    EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
}

TEST_F(GlTest, ClipSpaceDepthIsZeroToOne) {
    GLint origin = 0, depth = 0;
    glGetIntegerv(GL_CLIP_ORIGIN, &origin);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &depth);
    EXPECT_EQ(origin, GL_LOWER_LEFT);
    EXPECT_EQ(depth, GL_ZERO_TO_ONE);
}

/// Every kind either works or says in an InputError why not; which of them exist is the machine's
/// business.
TEST(Context, OtherKindsWorkOrSayWhyNot) {
    for (const ContextKind kind : {ContextKind::egl, ContextKind::glfw, ContextKind::automatic}) {
        test::endGlContext();
        try {
            const auto context = Context::create(kind);
            EXPECT_FALSE(context->renderer().empty());
            EXPECT_TRUE(kind == ContextKind::automatic || context->kind() == kind);
            EXPECT_EQ(takeErrors(), "");
        } catch (const InputError& e) {
            EXPECT_NE(kind, ContextKind::automatic) << "auto falls back to osmesa: " << e.what();
            EXPECT_TRUE(contains(e.what(), kind == ContextKind::egl ? "egl" : "glfw")) << e.what();
        }
    }
}

TEST(Context, EglDrawsWithoutADisplay) {
    test::endGlContext();
    std::unique_ptr<Context> context;
    try {
        context = Context::create(ContextKind::egl);
    } catch (const InputError& e) {
        GTEST_SKIP() << e.what();
    }
    const ShaderFolder shaders;
    shaders.write("x.glsl", fragment("void main() { result = vec4(1.0, 2.0, 3.0, 4.0); }\n"));
    EXPECT_EQ(drawPixel(Program::graphics("x.glsl")), (std::array{1.0f, 2.0f, 3.0f, 4.0f}));
    EXPECT_EQ(takeErrors(), "");
}

TEST_F(GlTest, ErrorsAreCollectedOnceAndNamed) {
    glEnable(GL_TEXTURE_WRAP_S);
    const std::string errors = takeErrors();
    EXPECT_TRUE(contains(errors, "GL_INVALID_ENUM")) << errors;
    EXPECT_EQ(takeErrors(), "");
    glEnable(GL_TEXTURE_WRAP_S);
    const std::string thrown = messageOf<std::runtime_error>([] { checkErrors("hard, frame 3"); });
    EXPECT_TRUE(thrown.starts_with("hard, frame 3: ")) << thrown;
    EXPECT_NO_THROW(checkErrors("after"));
}

TEST_F(GlTest, ManyErrorsAreBounded) {
    for (int i = 0; i < 100000; ++i) glEnable(GL_TEXTURE_WRAP_S);
    EXPECT_LT(takeErrors().size(), 10000u);
}

/// DESIGN section 8: under llvmpipe GL_TIME_ELAPSED reads a few per cent of the truth.
TEST_F(GlTest, TimerQueriesAreRefusedUnderLlvmpipe) {
    const ClockSelfTest test = runClockSelfTest();
    EXPECT_FALSE(test.timerQueriesTrusted);
    EXPECT_GE(test.fencedMs, 5.0);  // it aims at 10 ms, the best of three may be shorter
    EXPECT_LT(test.queryMs, 0.5 * test.fencedMs);
}

TEST_F(GlTest, HandlesMoveAndDelete) {
    Texture a = Texture::create2D(GL_R32F, 4, 4);
    const GLuint id = a.id();
    Texture b = std::move(a);
    EXPECT_FALSE(a);  // NOLINT: the moved-from state is what is tested
    EXPECT_EQ(a.mebibytes(), 0.0);
    EXPECT_EQ(b.id(), id);
    EXPECT_TRUE(glIsTexture(id));
    { const Texture c = std::move(b); }
    EXPECT_FALSE(glIsTexture(id));
}

TEST_F(GlTest, TextureSizesAreCountedOverLevelsAndLayers) {
    constexpr double kMiB = 1024.0 * 1024.0;
    EXPECT_EQ(Texture::create2D(GL_R32F, 512, 512).mebibytes(), 1.0);
    EXPECT_EQ(Texture::create2D(GL_RGBA32F, 256, 128).mebibytes(), 0.5);
    EXPECT_EQ(Texture::create2D(GL_R8, 3, 5).mebibytes(), 15 / kMiB);
    EXPECT_EQ(Texture::create2D(GL_RG16, 8, 4, 4).mebibytes(), 4 * (32 + 8 + 2 + 1) / kMiB);
    const Texture array = Texture::createArray(GL_DEPTH_COMPONENT32F, 256, 256, 5);
    EXPECT_EQ(array.mebibytes(), 5 * 0.25);
    EXPECT_EQ(array.layers(), 5);
    EXPECT_EQ(Texture().mebibytes(), 0.0);
    EXPECT_THROW(Texture::create2D(GL_RGB10, 4, 4), std::logic_error);
    EXPECT_THROW(Texture::create2D(GL_R8, 0, 4), std::logic_error);
    EXPECT_THROW(Texture::createArray(GL_R8, 4, 4, 0), std::logic_error);
    const std::string tooLarge =
        messageOf<std::runtime_error>([] { Texture::create2D(GL_R8, 1 << 20, 4); });
    EXPECT_TRUE(contains(tooLarge, "1048576")) << tooLarge;
}

TEST_F(GlTest, BuffersKeepTheirBytes) {
    const std::array<std::uint32_t, 3> data = {1, 2, 3};
    const Buffer buffer = Buffer::create(sizeof data, data.data());
    std::array<std::uint32_t, 3> read{};
    glGetNamedBufferSubData(buffer.id(), 0, sizeof read, read.data());
    EXPECT_EQ(read, data);
    EXPECT_EQ(buffer.bytes(), sizeof data);
    const std::uint8_t byte = 7;
    const Buffer small = Buffer::create(1, &byte);
    std::uint8_t readByte = 0;
    glGetNamedBufferSubData(small.id(), 0, 1, &readByte);
    EXPECT_EQ(readByte, 7);
    EXPECT_TRUE(Buffer::create(0, nullptr));
}

TEST_F(GlTest, IncludesAreResolvedInEveryBranchAndOnlyOnce) {
    const ShaderFolder shaders;
    shaders.write("common/a.glsl", "#include \"common/b.glsl\"\nfloat a() { return b() + 1.0; }\n");
    // Includes itself: the guards, not luck, must end this.
    shaders.write("common/b.glsl", "#include \"common/b.glsl\"\nfloat b() { return 10.0; }\n");
    shaders.write("x.glsl", "#ifdef NEVER\n#include \"common/b.glsl\"\n#endif\n" +
                                fragment("  #  include \"common/b.glsl\"  // again\n"
                                         "#include \"common/a.glsl\"\n"
                                         "#include \"common/b.glsl\"\n"
                                         "void main() { result = vec4(a(), b(), VALUE, 0.0); }\n"));
    EXPECT_EQ(drawPixel(Program::graphics("x.glsl", {"VALUE 3.0"})),
              (std::array{11.0f, 10.0f, 3.0f, 0.0f}));
}

TEST_F(GlTest, CompileErrorsNameFileAndLine) {
    const ShaderFolder shaders;
    shaders.write("common/bad.glsl", "// first line\nfloat f() { return undeclared_name; }\n");
    shaders.write("in_include.glsl", fragment("#include \"common/bad.glsl\"\n"
                                              "void main() { result = vec4(f()); }\n"));
    std::string message =
        messageOf<std::runtime_error>([] { Program::graphics("in_include.glsl"); });
    EXPECT_TRUE(contains(message, "common/bad.glsl:2")) << message;
    EXPECT_TRUE(contains(message, "undeclared_name")) << message;

    shaders.write("common/good.glsl", "float f() { return 1.0; }\n");
    shaders.write("after_include.glsl",
                  "#include \"common/good.glsl\"\n#ifdef STAGE_VERTEX\nvoid main() {}\n#else\n"
                  "void main() { oops; }\n#endif\n");
    message = messageOf<std::runtime_error>([] { Program::graphics("after_include.glsl"); });
    EXPECT_TRUE(contains(message, "after_include.glsl:5")) << message;
    EXPECT_TRUE(contains(message, "FRAGMENT")) << message;
}

/// Drivers that are not here write their places differently.
TEST(ShaderSource, LogsOfEveryDriverAreMapped) {
    ShaderSource source;
    source.files = {"(defines)", "hard.glsl", "common/bias.glsl"};
    EXPECT_EQ(source.mapLog("0:100012(5): error: Mesa\n"
                            "0(200007) : error C1008: NVIDIA\n"
                            "ERROR: 0:100003: 'x' : glslang\n"
                            "1 error generated\n"
                            "0:900001: no such file\n"),
              "hard.glsl:12(5): error: Mesa\n"
              "common/bias.glsl:7 : error C1008: NVIDIA\n"
              "ERROR: hard.glsl:3: 'x' : glslang\n"
              "1 error generated\n"
              "0:900001: no such file");
}

TEST_F(GlTest, MissingAndMalformedIncludesAreNamed) {
    const ShaderFolder shaders;
    EXPECT_TRUE(contains(messageOf<std::runtime_error>([] { Program::graphics("nowhere.glsl"); }),
                         "nowhere.glsl"));
    shaders.write("x.glsl", "\n#include \"common/nowhere.glsl\"\n");
    std::string message = messageOf<std::runtime_error>([] { Program::graphics("x.glsl"); });
    EXPECT_TRUE(message.starts_with("x.glsl:2: ")) << message;
    EXPECT_TRUE(contains(message, "common/nowhere.glsl")) << message;
    shaders.write("x.glsl", "#include <common/a.glsl>\n");
    message = messageOf<std::runtime_error>([] { Program::graphics("x.glsl"); });
    EXPECT_TRUE(message.starts_with("x.glsl:1: ")) << message;
}

TEST_F(GlTest, ComputeStageIsBuiltWithItsDefine) {
    const ShaderFolder shaders;
    shaders.write("x.glsl",
                  "#ifdef STAGE_COMPUTE\n"
                  "layout(local_size_x = 1) in;\n"
                  "layout(std430, binding = 0) buffer Out { uint answer; };\n"
                  "uniform uint value;\n"
                  "void main() { answer = value + EXTRA; }\n#endif\n");
    const Program program = Program::compute("x.glsl", {"EXTRA 2u"});
    const Buffer out = Buffer::create(4, nullptr);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, out.id());
    program.set("value", 40u);
    program.use();
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::uint32_t answer = 0;
    glGetNamedBufferSubData(out.id(), 0, sizeof answer, &answer);
    EXPECT_EQ(answer, 42u);
}

TEST_F(GlTest, UniformsOfEveryTypeArriveAndUnusedNamesAreIgnored) {
    const ShaderFolder shaders;
    shaders.write("x.glsl", fragment("uniform int i; uniform uint u; uniform float f;\n"
                                     "uniform vec2 v2; uniform vec3 v3; uniform vec4 v4;\n"
                                     "uniform mat4 m;\n"
                                     "void main() {\n"
                                     "    result = m * v4 + vec4(v3, f) + vec4(v2, i, u);\n"
                                     "}\n"));
    const Program program = Program::graphics("x.glsl");
    program.set("i", -3);
    program.set("u", 5u);
    program.set("f", 0.25f);
    program.set("v2", glm::vec2(1, 2));
    program.set("v3", glm::vec3(10, 20, 30));
    program.set("v4", glm::vec4(0, 0, 0, 1));
    program.set("m", glm::translate(glm::mat4(1.0f), glm::vec3(100, 200, 300)));
    program.set("no_such_uniform", 1.0f);
    EXPECT_EQ(drawPixel(program), (std::array{111.0f, 222.0f, 327.0f, 6.25f}));
}

struct AllKinds : Parameters {
    IntParameter taps{this, "taps", 16, 1, 64, "", "an int"};
    FloatParameter radius{this, "radius", 0.5, 0, 8, "m", "a float"};
    BoolParameter fast{this, "fast", false, "a bool"};
    ChoiceParameter pattern{this, "pattern", {"grid", "vogel"}, "a choice"};
};

TEST_F(GlTest, ParametersBecomeUniforms) {
    const ShaderFolder shaders;
    shaders.write("x.glsl",
                  fragment("uniform int p_taps; uniform float p_radius; uniform bool p_fast;\n"
                           "uniform int p_pattern;\n"
                           "void main() {\n"
                           "    result = vec4(p_taps, p_radius, p_fast ? 1 : 0, p_pattern);\n"
                           "}\n"));
    const Program program = Program::graphics("x.glsl");
    AllKinds parameters;
    program.set(parameters);
    EXPECT_EQ(drawPixel(program), (std::array{16.0f, 0.5f, 0.0f, 0.0f}));
    parameters.set("x", "taps", "3");
    parameters.set("x", "radius", "2.25");
    parameters.set("x", "fast", "true");
    parameters.set("x", "pattern", "vogel");
    program.set(parameters);
    EXPECT_EQ(drawPixel(program), (std::array{3.0f, 2.25f, 1.0f, 1.0f}));
}

TEST(ShaderFolder, FollowsTheEnvironment) {
    EXPECT_TRUE(std::filesystem::is_directory(shaderFolder() / "common"));
    setenv("PENUMBRA_SHADERS", "elsewhere", 1);
    EXPECT_EQ(shaderFolder(), "elsewhere");
    unsetenv("PENUMBRA_SHADERS");
}

}  // namespace
}  // namespace penumbra::gl
