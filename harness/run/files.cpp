#include "harness/run/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace penumbra {

namespace {

/// Whether what was written to `path` is on the disk.
bool synchronise(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return false;
    const bool done = ::fsync(fd) == 0;
    ::close(fd);
    return done;
}

}  // namespace

void writeFileAtomically(const std::filesystem::path& path, const std::string& text, bool durable) {
    const std::filesystem::path temporary = fmt::format("{}.{}.tmp", path.string(), getpid());
    std::ofstream file(temporary, std::ios::binary);
    file << text;
    file.close();
    std::error_code error;
    const bool written = file && (!durable || synchronise(temporary));
    if (written) std::filesystem::rename(temporary, path, error);
    if (!written || error) {
        const std::string reason = error ? error.message() : std::strerror(errno);
        std::filesystem::remove(temporary, error);
        throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), reason));
    }
}

void appendToStepSummary(const std::string& markdown) {
    if (const char* step = std::getenv("GITHUB_STEP_SUMMARY"); step && *step)
        std::ofstream(step, std::ios::app) << markdown;
}

}  // namespace penumbra
