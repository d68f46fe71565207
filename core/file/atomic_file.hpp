#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string_view>

namespace penumbra {

/// Writes `bytes` under a temporary name beside `path` and renames it there. Readers, other
/// processes and threads that write the same file, a full disk and the end of this process at any
/// moment leave at `path` the old file or the whole new one; what a kill can leave beside it is a
/// temporary file. With `durable` the bytes are on the disk before their name is, so that this also
/// holds against a power cut; without it, it does not. Throws std::runtime_error with file and
/// reason.
void writeFileAtomically(const std::filesystem::path& path, std::string_view bytes,
                         bool durable = false);

/// Whether `path` ends as the names under which writeFileAtomically writes: ".<16 hex>.tmp".
bool isTemporaryFile(const std::filesystem::path& path);

/// Removes files in `folder`, not below it, that a process which was killed left there: temporary
/// ones of names for which `mine` is true, last written more than `age` ago. Nobody writes longer
/// than that, for the bytes are complete before the file is opened. What cannot be removed stays.
void removeStaleTemporaries(const std::filesystem::path& folder, std::chrono::hours age,
                            const std::function<bool(std::string_view name)>& mine);

}  // namespace penumbra
