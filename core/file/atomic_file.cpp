#include "core/file/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <random>
#include <stdexcept>
#include <system_error>

namespace penumbra {
namespace {

constexpr std::string_view kSuffix = ".tmp";
constexpr std::size_t kDigits = 16;

/// A name that no other writer has: process ids alone repeat between containers that share a
/// folder.
std::string temporaryName(const std::filesystem::path& path) {
    static const std::uint64_t process = [] {
        std::random_device random;
        return std::uint64_t{random()} << 32 ^ random() ^ static_cast<std::uint64_t>(getpid());
    }();
    static std::atomic<std::uint64_t> count{0};
    return fmt::format("{}.{:016x}{}", path.string(), process + count++, kSuffix);
}

int writeAll(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return 0;
}

/// 0, or errno of what failed.
int writeNew(const std::string& name, std::string_view bytes, bool durable) {
    const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) return errno;
    int error = writeAll(fd, bytes);
    if (!error && durable && ::fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && !error) error = errno;
    return error;
}

}  // namespace

void writeFileAtomically(const std::filesystem::path& path, std::string_view bytes, bool durable) {
    const std::string temporary = temporaryName(path);
    int error = writeNew(temporary, bytes, durable);
    if (!error && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    if (!error) return;
    if (error != EEXIST) ::unlink(temporary.c_str());
    throw std::runtime_error(
        fmt::format("{}: cannot be written: {}", path.string(), std::strerror(error)));
}

bool isTemporaryFile(const std::filesystem::path& path) {
    std::string name = path.filename().string();
    if (!name.ends_with(kSuffix) || name.size() <= kSuffix.size() + kDigits + 1) return false;
    name.resize(name.size() - kSuffix.size());
    const std::string digits = name.substr(name.size() - kDigits);
    return name[name.size() - kDigits - 1] == '.' &&
           digits.find_first_not_of("0123456789abcdef") == std::string::npos;
}

void removeStaleTemporaries(const std::filesystem::path& folder, std::chrono::hours age,
                            const std::function<bool(std::string_view name)>& mine) {
    const auto newest = std::filesystem::file_time_type::clock::now() - age;
    std::error_code error;  // what another process removes meanwhile is gone: good
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
         at.increment(error)) {
        const std::filesystem::path& path = at->path();
        std::error_code ignored;
        if (!isTemporaryFile(path) || !mine(path.filename().string()) ||
            !at->is_regular_file(ignored))
            continue;
        const auto written = at->last_write_time(ignored);
        if (!ignored && written < newest) std::filesystem::remove(path, ignored);
    }
}

}  // namespace penumbra
