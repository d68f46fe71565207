#include "core/scene/input_text.hpp"

#include <fmt/format.h>

#include <span>

#include "core/error.hpp"

namespace penumbra::scene_detail {

std::string oneLine(std::string text, std::size_t maxLength) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    text.erase(text.find_last_not_of(' ') + 1);
    if (text.size() > maxLength) text = text.substr(0, maxLength) + "...";
    return text;
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
