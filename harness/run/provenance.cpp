#include "harness/run/provenance.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>

namespace penumbra {
namespace {

/// First line that `command` prints, or empty if it fails.
std::string firstLine(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::array<char, 256> line{};
    if (!pipe || !std::fgets(line.data(), line.size(), pipe.get())) return "";
    std::string text = line.data();
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    return text;
}

std::string commitOfTree() {
    const std::string git = "git -C '" PENUMBRA_SOURCE_DIR "' ";
    const std::string hash = firstLine(git + "rev-parse --short=12 HEAD 2>/dev/null");
    if (hash.empty()) return "unknown";
    const bool changed =
        !firstLine(git + "status --porcelain --untracked-files=no 2>/dev/null").empty();
    return changed ? hash + "+" : hash;
}

std::string cpuModel() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) {
            const auto colon = line.find(": ");
            if (colon != std::string::npos) return line.substr(colon + 2);
        }
    return "unknown";
}

std::string contextName(gl::ContextKind kind) {
    switch (kind) {
        case gl::ContextKind::egl:
            return "egl";
        case gl::ContextKind::glfw:
            return "glfw";
        default:
            return "osmesa";
    }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> Provenance::pairs() const {
    return {{"renderer", renderer},
            {"gl_version", glVersion},
            {"context", context},
            {"cpu", cpu},
            {"threads", std::to_string(threads)},
            {"build", buildType},
            {"compiler", compiler},
            {"version", version},
            {"commit", commit},
            {"started", started}};
}

Provenance gatherProvenance(const gl::Context& context, int threads) {
    Provenance p = gatherProvenance(threads);
    p.renderer = context.renderer();
    p.glVersion = context.version();
    p.context = contextName(context.kind());
    return p;
}

Provenance gatherProvenance(int threads) {
    Provenance p;
    p.renderer = kExternalRenderer;
    p.glVersion = p.context = "none";
    p.cpu = cpuModel();
    p.buildType = PENUMBRA_BUILD_TYPE;
    p.compiler = "g++ " __VERSION__;
    p.version = PENUMBRA_VERSION;
    p.commit = commitOfTree();
    p.started = utcNow("%Y-%m-%dT%H:%M:%SZ");
    p.threads = threads;
    return p;
}

std::string userName() {
    const std::string name = firstLine("git config user.name 2>/dev/null");
    const std::string mail = firstLine("git config user.email 2>/dev/null");
    if (!name.empty()) return mail.empty() ? name : fmt::format("{} <{}>", name, mail);
    const char* login = std::getenv("USER");
    return login && *login ? login : "unknown";
}

std::filesystem::path resultsFolder() {
    return PENUMBRA_SOURCE_DIR "/results";
}

std::string utcNow(const char* format) {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 64> text{};
    std::strftime(text.data(), text.size(), format, &utc);
    return text.data();
}

}  // namespace penumbra
