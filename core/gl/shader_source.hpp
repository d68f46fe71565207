#pragma once

#include <string>
#include <vector>

namespace penumbra::gl {

/// One stage's text, ready for the compiler, and the way back from its line numbers.
struct ShaderSource {
    std::string text;
    std::vector<std::string> files;  ///< in order of first inclusion, relative to shaders/

    /// A driver's log with the places in `text` that it names turned into "common/x.glsl:12".
    std::string mapLog(const std::string& log) const;
};

/// Reads `file` (relative to shaders/), puts `#version 450 core`, `#define STAGE_<stage>` and the
/// caller's defines before it and resolves its includes. Throws std::runtime_error with file:line.
ShaderSource readShader(const std::string& file, const std::string& stage,
                        const std::vector<std::string>& defines);

}  // namespace penumbra::gl
