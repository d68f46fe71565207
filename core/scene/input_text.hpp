#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace penumbra::scene_detail {

/// Throws InputError("file: where: what"), or without `where` when that is empty. The message is
/// made one line of bounded length, for names in it may come from an untrusted file.
[[noreturn]] void failInput(const std::filesystem::path& file, const std::string& where,
                            const std::string& what);

/// `text` without control characters, cut after `maxLength` bytes.
std::string oneLine(std::string text, std::size_t maxLength = 600);

/// "a, b, c"; with `most`, "a, b and 7 more".
std::string listed(const std::vector<std::string>& words, std::size_t most = SIZE_MAX);

}  // namespace penumbra::scene_detail
