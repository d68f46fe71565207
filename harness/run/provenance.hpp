#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/gl/context.hpp"

namespace penumbra {

/// Where a run's numbers come from.
struct Provenance {
    std::string renderer;   ///< GL_RENDERER
    std::string glVersion;  ///< GL_VERSION
    std::string context;    ///< osmesa | egl | glfw
    std::string cpu;
    std::string buildType;
    std::string compiler;
    std::string version;  ///< of Penumbra
    std::string
        commit;  ///< short hash, "+" appended when the tree was changed, "unknown" outside git
    std::string started;  ///< UTC, ISO 8601
    int threads = 0;

    std::vector<std::pair<std::string, std::string>> pairs() const;
};

Provenance gatherProvenance(const gl::Context& context, int threads);

/// The renderer of images that were not made here.
inline constexpr const char* kExternalRenderer = "external";

/// Where the numbers of a run come from that renders nothing itself: kExternalRenderer, no OpenGL.
Provenance gatherProvenance(int threads);

/// Who works here: git's user.name and user.email, else the login name, else "unknown".
std::string userName();

/// The `results` folder of the source tree this program was built from.
std::filesystem::path resultsFolder();

/// Now in UTC as strftime `format`.
std::string utcNow(const char* format);

}  // namespace penumbra
