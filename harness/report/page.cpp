#include "harness/report/page.hpp"

#include <fmt/format.h>
#include <nettle/base64.h>
#include <nettle/sha2.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/error.hpp"
#include "harness/report/escape.hpp"
#include "harness/report/page_modules.hpp"
#include "harness/run/csv.hpp"

namespace penumbra {
namespace {

constexpr const char* kChartScript = "/usr/share/javascript/chart.js/chart.min.js";
constexpr const char* kChartLicence = "/usr/share/doc/libjs-chart.js/copyright";

/// As a Content-Security-Policy names an inline element.
std::string sourceHash(const std::string& text) {
    std::array<unsigned char, SHA256_DIGEST_SIZE> digest{};
    sha256_ctx context;
    sha256_init(&context);
    sha256_update(&context, text.size(), reinterpret_cast<const std::uint8_t*>(text.data()));
    sha256_digest(&context, digest.size(), digest.data());
    return fmt::format("'sha256-{}'", base64(digest));
}

/// A part of the page that must not end the element it stands in.
std::string partOfPage(std::string text, const std::string& name) {
    for (const char* forbidden : {"</script", "</style", "<!--"})
        if (text.find(forbidden) != std::string::npos)
            throw std::runtime_error(fmt::format("{}: holds {}", name, forbidden));
    return text;
}

std::string readPart(const std::string& name) {
    return partOfPage(readTextFile(pageFolder() / name), name);
}

std::string readChartFile(const char* path) {
    try {
        return partOfPage(readTextFile(path), path);
    } catch (const InputError& e) {
        throw std::runtime_error(
            fmt::format("{} (Debian package libjs-chart.js is needed)", e.what()));
    }
}

}  // namespace

std::filesystem::path pageFolder() {
    const char* folder = std::getenv("PENUMBRA_PAGES");
    return folder && *folder ? folder : PENUMBRA_SOURCE_DIR "/harness/report/page";
}

PageData jsonData(const std::string& id, const nlohmann::ordered_json& json) {
    const std::string plain =
        json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    std::string text;
    text.reserve(plain.size());
    for (const char c : plain) {
        if (c == '<')
            text += "\\u003c";  // JSON has it in strings only
        else
            text += c;
    }
    return {id, "application/json", std::move(text)};
}

std::string base64(std::span<const unsigned char> bytes) {
    std::string text(BASE64_ENCODE_RAW_LENGTH(bytes.size()), '\0');
    base64_encode_raw(text.data(), bytes.size(), bytes.data());
    return text;
}

std::string dataElement(const PageData& data) {
    const auto isIdCharacter = [](unsigned char c) { return std::isalnum(c) || c == '-'; };
    if (data.id.empty() || !std::ranges::all_of(data.id, isIdCharacter))
        throw std::invalid_argument("no id of page data: " + data.id);
    if (data.type.find("script") != std::string::npos ||
        data.type.find_first_of("\"<>&") != std::string::npos)
        throw std::invalid_argument("no type of page data: " + data.type);
    if (data.text.find('<') != std::string::npos)
        throw std::invalid_argument("page data holds '<': " + data.id);
    return fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", data.type, data.id,
                       data.text);
}

PageShell pageShell(const PageSource& source, std::span<const PageData> data) {
    std::string style = readPart("page.css");
    for (const std::string& name : source.styles) style += readPart(name);
    // A module element would wait for the end of the document, and so for all of the bulk data.
    const std::string script = "\"use strict\";\n(() => {\n" +
                               partOfPage(joinModules(pageFolder(), source.script), source.script) +
                               "})();\n";
    const std::string charts = source.charts ? readChartFile(kChartScript) : "";
    const std::string policy = fmt::format(
        "default-src 'none'; script-src {} {}; style-src {}; "
        "base-uri 'none'; form-action 'none'",
        sourceHash(script), source.charts ? sourceHash(charts) : "", sourceHash(style));

    PageShell shell;
    shell.head = fmt::format(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}",
        policy, xmlEscaped(source.title), style, readPart(source.markup));
    for (const PageData& one : data) shell.head += dataElement(one);
    if (source.charts) {
        shell.head += dataElement(jsonData("chart-licence", readChartFile(kChartLicence)));
        shell.head += fmt::format("<script>{}</script>\n", charts);
    }
    shell.head += fmt::format("<script>{}</script>\n", script);
    shell.tail = "</body>\n</html>\n";
    return shell;
}

}  // namespace penumbra
