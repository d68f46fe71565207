#include "harness/run/files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace penumbra {

void writeFileAtomically(const std::filesystem::path& path, const std::string& text) {
    const std::filesystem::path temporary = fmt::format("{}.{}.tmp", path.string(), getpid());
    std::ofstream file(temporary, std::ios::binary);
    file << text;
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(temporary, path, error);
    if (!file || error) {
        const std::string reason = error ? error.message() : std::strerror(errno);
        std::filesystem::remove(temporary, error);
        throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), reason));
    }
}

}  // namespace penumbra
