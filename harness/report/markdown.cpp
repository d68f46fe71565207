#include "harness/report/markdown.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace penumbra::markdown {

namespace {

std::string tableLine(const Cells& cells) {
    return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

}  // namespace

std::string escaped(std::string_view text) {
    const auto isWord = [&](std::size_t i) {
        return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
    };
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        // Markdown leaves snake_case alone, and so stay the names readable in the source.
        const bool insideWord = c == '_' && i > 0 && isWord(i - 1) && isWord(i + 1);
        if (c == '\n') {
            out += "<br>";
        } else if (c == '<') {
            out += "&lt;";
        } else if (c == '&') {
            out += "&amp;";
        } else if (c != '\r') {
            if (!insideWord && std::string_view("\\`*_[]|~").find(c) != std::string_view::npos) {
                out += '\\';
            }
            out += c;
        }
    }
    return out;
}

std::string table(const Cells& header, std::size_t textColumns, const std::vector<Cells>& lines) {
    std::string out = tableLine(header) + "|";
    for (std::size_t i = 0; i < header.size(); ++i) out += i < textColumns ? ":--|" : "--:|";
    out += '\n';
    for (const Cells& line : lines) out += tableLine(line);
    return out + '\n';
}

std::string number(const Number& value) {
    if (!value) return "";
    const double magnitude = std::abs(*value);
    if (magnitude == 0.0) return "0";
    if (magnitude < 1e-4 || magnitude >= 1e15) return fmt::format("{:.2e}", *value);
    const int digits = std::clamp(2 - static_cast<int>(std::floor(std::log10(magnitude))), 0, 6);
    return fmt::format("{:.{}f}", *value, digits);
}

std::string whole(const Number& value) {
    return value ? fmt::format("{:.0f}", *value) : "";
}

std::string count(double value) {
    if (value >= 1e9) return number(value / 1e9) + " G";
    if (value >= 1e6) return number(value / 1e6) + " M";
    if (value >= 1e4) return number(value / 1e3) + " k";
    return whole(value);
}

std::string percent(const Number& fraction) {
    return fraction ? number(100.0 * *fraction) + " %" : "";
}

std::string seconds(double value) {
    return number(value) + " s";
}

Number ratio(double part, double whole) {
    return whole > 0 ? Number(part / whole) : std::nullopt;
}

}  // namespace penumbra::markdown
