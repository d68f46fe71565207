#include "core/scene/choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {

std::optional<std::size_t> chosenByIndexOrName(const std::string& wanted,
                                               const std::vector<std::string>& names) {
    std::size_t index = 0;
    const char* const end = wanted.data() + wanted.size();
    const auto read = std::from_chars(wanted.data(), end, index);
    if (read.ec == std::errc() && read.ptr == end && index < names.size()) return index;
    if (std::count(names.begin(), names.end(), wanted) != 1) return std::nullopt;
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), wanted) - names.begin());
}

std::string indexedNames(const std::vector<std::string>& names) {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < names.size(); ++i) {
        words.push_back(names[i].empty() ? std::to_string(i)
                                         : fmt::format("{} '{}'", i, oneLine(names[i], 60)));
    }
    return listed(words, 12);
}

}  // namespace penumbra::scene_detail
