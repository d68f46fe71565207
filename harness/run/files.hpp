#pragma once

#include <filesystem>
#include <string>

namespace penumbra {

/// Writes `text` beside `path` and renames it there: readers see the old file or the whole new one.
/// Throws std::runtime_error with the reason.
void writeFileAtomically(const std::filesystem::path& path, const std::string& text);

}  // namespace penumbra
