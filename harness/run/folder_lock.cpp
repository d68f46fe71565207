#include "harness/run/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/error.hpp"

namespace penumbra {

FolderLock::FolderLock(const std::filesystem::path& folder)
    // Closed in programs that this one starts: they may outlive it.
    : fd_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (fd_ < 0) throw InputError(fmt::format("{}: {}", folder.string(), std::strerror(errno)));
    if (::flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
    ::close(fd_);
    throw InputError(
        fmt::format("{}: another process is writing to this folder; wait for it or "
                    "choose another folder",
                    folder.string()));
}

FolderLock::~FolderLock() {
    ::close(fd_);
}

}  // namespace penumbra
