#include "core/scene/input_text.hpp"

#include <fmt/format.h>

#include <span>

#include "core/error.hpp"

namespace penumbra::scene_detail {

std::string oneLine(std::string text, std::size_t maxLength) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    // The same in UTF-8: U+0080 to U+009F, which terminals obey; line separators and what turns
    // the direction of writing, U+2028 to U+202E.
    for (std::size_t i = 1; i < text.size(); ++i) {
        const auto at = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
        if (at(i - 1) == 0xC2 && at(i) >= 0x80 && at(i) <= 0x9F) text.replace(i - 1, 2, "  ");
        if (i < 2 || at(i - 2) != 0xE2 || at(i - 1) != 0x80) continue;
        if (at(i) >= 0xA8 && at(i) <= 0xAE) text.replace(i - 2, 3, "   ");
    }
    text.erase(text.find_last_not_of(' ') + 1);
    if (text.size() <= maxLength) return text;
    std::size_t end = maxLength;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
    return text.substr(0, end) + "...";
}

std::string listed(const std::vector<std::string>& words, std::size_t most) {
    if (words.size() <= most) return fmt::format("{}", fmt::join(words, ", "));
    return fmt::format("{} and {} more", fmt::join(std::span(words).first(most), ", "),
                       words.size() - most);
}

void failInput(const std::filesystem::path& file, const std::string& where,
               const std::string& what) {
    const std::string place = where.empty() ? file.string() : file.string() + ": " + where;
    throw InputError(oneLine(place + ": " + what, 2000));
}

}  // namespace penumbra::scene_detail
