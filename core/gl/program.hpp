#pragma once

#include <glad/gl.h>

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/gl/handles.hpp"

namespace penumbra {
class Parameters;
}

namespace penumbra::gl {

struct ProgramTraits {
    static void destroy(GLuint id) { glDeleteProgram(id); }
};

/// A linked program made of one .glsl file. The file holds all stages of all its passes: it is
/// compiled once per stage with `STAGE_VERTEX`, `STAGE_FRAGMENT` or `STAGE_COMPUTE` defined, after
/// the caller's defines (one `PASS_…` and whatever else). `#include "common/x.glsl"` is resolved
/// relative to shaders/, each file at most once per stage.
class Program : public Handle<ProgramTraits> {
  public:
    Program() = default;
    /// `file` relative to shaders/. Each define is "NAME" or "NAME VALUE". A file that defines
    /// compute work is built with `compute()`. Throws std::runtime_error with the driver's log, its
    /// line numbers mapped back to the files.
    static Program graphics(const std::string& file, const std::vector<std::string>& defines = {});
    static Program compute(const std::string& file, const std::vector<std::string>& defines = {});

    void use() const { glUseProgram(id()); }
    /// Sets a uniform by name; a name the linked program does not use is ignored.
    void set(const char* name, int v) const;
    void set(const char* name, unsigned v) const;
    void set(const char* name, float v) const;
    void set(const char* name, glm::vec2 v) const;
    void set(const char* name, glm::vec3 v) const;
    void set(const char* name, glm::vec4 v) const;
    void set(const char* name, glm::ivec4 v) const;
    void set(const char* name, const glm::mat3& v) const;
    void set(const char* name, const glm::mat4& v) const;
    /// Sets `p_<id>` from every parameter: float, int and bool as themselves, choices as index.
    void set(const Parameters& parameters) const;

  private:
    using Handle::Handle;
};

/// shaders/ of this build, or $PENUMBRA_SHADERS where set.
std::filesystem::path shaderFolder();

}  // namespace penumbra::gl
