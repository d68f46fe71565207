#include "core/gl/program.hpp"

#include <cstdlib>
#include <glm/gtc/type_ptr.hpp>
#include <stdexcept>

#include "core/gl/shader_source.hpp"
#include "core/parameter/parameter.hpp"

namespace penumbra::gl {
namespace {

struct ShaderTraits {
    static void destroy(GLuint id) { glDeleteShader(id); }
};
using Shader = Handle<ShaderTraits>;

std::string shaderLog(GLuint shader) {
    GLint length = 0;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), '\0');
    GLsizei written = 0;
    glGetShaderInfoLog(shader, length, &written, log.data());
    log.resize(static_cast<std::size_t>(written));
    return log;
}

std::string programLog(GLuint program) {
    GLint length = 0;
    glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), '\0');
    GLsizei written = 0;
    glGetProgramInfoLog(program, length, &written, log.data());
    log.resize(static_cast<std::size_t>(written));
    return log;
}

Shader compile(GLenum type, const std::string& stage, const std::string& file,
               const std::vector<std::string>& defines) {
    const ShaderSource source = readShader(file, stage, defines);
    Shader shader(glCreateShader(type));
    const char* text = source.text.c_str();
    glShaderSource(shader.id(), 1, &text, nullptr);
    glCompileShader(shader.id());
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
    if (!compiled)
        throw std::runtime_error(file + " (" + stage +
                                 ") does not compile: " + source.mapLog(shaderLog(shader.id())));
    return shader;
}

void link(GLuint program, const std::vector<Shader>& shaders, const std::string& file) {
    for (const Shader& shader : shaders) glAttachShader(program, shader.id());
    glLinkProgram(program);
    for (const Shader& shader : shaders) glDetachShader(program, shader.id());
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) throw std::runtime_error(file + " does not link: " + programLog(program));
    glObjectLabel(GL_PROGRAM, program, -1, file.c_str());
}

}  // namespace

Program Program::graphics(const std::string& file, const std::vector<std::string>& defines) {
    std::vector<Shader> shaders;
    shaders.push_back(compile(GL_VERTEX_SHADER, "VERTEX", file, defines));
    shaders.push_back(compile(GL_FRAGMENT_SHADER, "FRAGMENT", file, defines));
    Program program(glCreateProgram());
    link(program.id(), shaders, file);
    return program;
}

Program Program::compute(const std::string& file, const std::vector<std::string>& defines) {
    std::vector<Shader> shaders;
    shaders.push_back(compile(GL_COMPUTE_SHADER, "COMPUTE", file, defines));
    Program program(glCreateProgram());
    link(program.id(), shaders, file);
    return program;
}

// An unused name has location -1, which glProgramUniform ignores.
void Program::set(const char* name, int v) const {
    glProgramUniform1i(id(), glGetUniformLocation(id(), name), v);
}

void Program::set(const char* name, unsigned v) const {
    glProgramUniform1ui(id(), glGetUniformLocation(id(), name), v);
}

void Program::set(const char* name, float v) const {
    glProgramUniform1f(id(), glGetUniformLocation(id(), name), v);
}

void Program::set(const char* name, glm::vec2 v) const {
    glProgramUniform2fv(id(), glGetUniformLocation(id(), name), 1, glm::value_ptr(v));
}

void Program::set(const char* name, glm::vec3 v) const {
    glProgramUniform3fv(id(), glGetUniformLocation(id(), name), 1, glm::value_ptr(v));
}

void Program::set(const char* name, glm::vec4 v) const {
    glProgramUniform4fv(id(), glGetUniformLocation(id(), name), 1, glm::value_ptr(v));
}

void Program::set(const char* name, glm::ivec4 v) const {
    glProgramUniform4iv(id(), glGetUniformLocation(id(), name), 1, glm::value_ptr(v));
}

void Program::set(const char* name, const glm::mat3& v) const {
    glProgramUniformMatrix3fv(id(), glGetUniformLocation(id(), name), 1, GL_FALSE,
                              glm::value_ptr(v));
}

void Program::set(const char* name, const glm::mat4& v) const {
    glProgramUniformMatrix4fv(id(), glGetUniformLocation(id(), name), 1, GL_FALSE,
                              glm::value_ptr(v));
}

void Program::set(const Parameters& parameters) const {
    for (const Parameter* parameter : parameters.parameters()) {
        const std::string name = "p_" + parameter->id();
        if (parameter->isFloat())
            set(name.c_str(), static_cast<float>(parameter->number()));
        else
            set(name.c_str(), static_cast<int>(parameter->number()));
    }
}

std::filesystem::path shaderFolder() {
    const char* folder = std::getenv("PENUMBRA_SHADERS");
    return folder && *folder ? folder : PENUMBRA_SOURCE_DIR "/shaders";
}

}  // namespace penumbra::gl
