#include "harness/report/escape.hpp"

#include <initializer_list>
#include <utility>

namespace penumbra {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD

/// Length of the UTF-8 sequence at the start of `text` if XML allows its character, else 0.
std::size_t sequenceLength(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
    unsigned code = first & (0xffU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(i) & 0x3fU);
    }
    constexpr unsigned kFirstOfLength[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    const bool noCharacter = code == 0xfffe || code == 0xffff || code > 0x10ffff;
    return code < kFirstOfLength[length] || surrogate || noCharacter ? 0 : length;
}

/// `text` with its line ends as `lineEnd`, what is no text replaced, and the characters of
/// `replaced` spelled otherwise.
std::string escape(std::string_view text, std::string_view lineEnd,
                   std::initializer_list<std::pair<char, std::string_view>> replaced) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        if (text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n') ++i;
        if (text[i] == '\n' || text[i] == '\r' || text[i] == '\t') {
            out += text[i] == '\t' ? " " : lineEnd;
            ++i;
            continue;
        }
        const std::size_t length = sequenceLength(text.substr(i));
        if (length == 0) {
            out += kReplacement;
            ++i;
            continue;
        }
        std::string_view character = text.substr(i, length);
        for (const auto& [special, spelled] : replaced)
            if (character.size() == 1 && character[0] == special) character = spelled;
        out += character;
        i += length;
    }
    return out;
}

}  // namespace

std::string printable(std::string_view text) {
    return escape(text, " ", {});
}

std::string xmlEscaped(std::string_view text) {
    return escape(text, "&#10;",
                  {{'<', "&lt;"}, {'>', "&gt;"}, {'&', "&amp;"}, {'"', "&quot;"}, {'\'', "&#39;"}});
}

std::string commandData(std::string_view text) {
    return escape(text, "%0A", {{'%', "%25"}});
}

std::string commandProperty(std::string_view text) {
    return escape(text, "%0A", {{'%', "%25"}, {':', "%3A"}, {',', "%2C"}});
}

}  // namespace penumbra
