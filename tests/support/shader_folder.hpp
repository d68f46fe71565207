#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/gl/program.hpp"

namespace penumbra::test {

/// Shaders of a test's own that include the project's: while it lives, programs are read from a
/// temporary folder in which common/ is the project's.
class ShaderFolder {
  public:
    ShaderFolder() {
        std::filesystem::create_directories(folder_);
        std::filesystem::create_directory_symlink(
            std::filesystem::absolute(gl::shaderFolder() / "common"), folder_ / "common");
        setenv("PENUMBRA_SHADERS", folder_.c_str(), 1);
    }
    ~ShaderFolder() {
        unsetenv("PENUMBRA_SHADERS");
        std::filesystem::remove_all(folder_);
    }
    ShaderFolder(const ShaderFolder&) = delete;
    ShaderFolder& operator=(const ShaderFolder&) = delete;
    void write(const std::string& file, const std::string& text) const {
        std::ofstream(folder_ / file) << text;
    }

  private:
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("penumbra_shaders_" + std::to_string(getpid()));
};

}  // namespace penumbra::test
