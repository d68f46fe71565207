#pragma once

#include <filesystem>

namespace penumbra {

/// A folder for this process alone, as long as it lives: whoever changes a run folder has one. It
/// is flock(2) on the folder itself, so nothing is left there, and it ends with its process however
/// that ends. Where a file system has no such locks, two processes are not kept apart.
class FolderLock {
  public:
    /// Throws InputError if another has the folder or it cannot be opened.
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    int fd_ = -1;
};

}  // namespace penumbra
