#include "core/scene/gltf_uri.hpp"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <cctype>
#include <fstream>
#include <optional>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

namespace fs = std::filesystem;

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    const char lower = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// A '%' that no two hexadecimal digits follow stays: exporters forget to escape it.
std::string percentDecoded(const std::string& uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? hexDigit(uri[i + 1]) : -1;
        const int low = high >= 0 ? hexDigit(uri[i + 2]) : -1;
        if (low < 0) {
            out += uri[i];
            continue;
        }
        out += static_cast<char>(16 * high + low);
        i += 2;
    }
    return out;
}

/// RFC 3986, section 3.1: letters, digits, +, - and . before a colon.
bool hasScheme(const std::string& uri) {
    const std::size_t end =
        uri.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.");
    return end != std::string::npos && end > 0 && uri[end] == ':';
}

/// Nothing where the path leads out of `folder`.
std::optional<fs::path> resolvedInside(const fs::path& folder, const std::string& decoded) {
    const fs::path relative = decoded;
    if (hasScheme(decoded) || relative.is_absolute() || decoded.find('\0') != std::string::npos ||
        decoded.find('\\') != std::string::npos) {
        return std::nullopt;
    }
    for (const fs::path& step : relative) {
        if (step == "..") return std::nullopt;
    }
    std::error_code error;
    const fs::path home = fs::canonical(folder.empty() ? "." : folder, error);
    if (error) return std::nullopt;
    const fs::path target = fs::weakly_canonical(home / relative, error);
    if (error) return std::nullopt;
    const fs::path inside = target.lexically_relative(home);
    if (inside.empty() || *inside.begin() == "..") return std::nullopt;
    return target;
}

}  // namespace

std::vector<unsigned char> readBytes(const fs::path& path, const std::string& name,
                                     const fs::path& file, const std::string& pointer,
                                     MemoryBudget& budget) {
    const auto unreadable = [&] {
        failInput(file, pointer,
                  name.empty()
                      ? "is not a readable file"
                      : fmt::format("'{}' is missing or not a readable file", oneLine(name, 200)));
    };
    std::error_code error;
    if (!fs::is_regular_file(path, error)) unreadable();
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) unreadable();
    budget.charge(size, 1, pointer, "reading the file");
    std::vector<unsigned char> bytes(size);
    std::ifstream in(path, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
        unreadable();
    }
    return bytes;
}

std::vector<unsigned char> readUri(const std::string& uri, const fs::path& file,
                                   const std::string& pointer, MemoryBudget& budget) {
    if (uri.starts_with("data:")) {
        // Decoding holds the text once more and the bytes twice.
        budget.charge(uri.size(), 3, pointer, "decoding the data URI");
        std::vector<unsigned char> bytes;
        std::string mimeType;
        if (!tinygltf::DecodeDataURI(&bytes, mimeType, uri, 0, false)) {
            failInput(file, pointer,
                      fmt::format("'{}' is no base64 data URI of a buffer, PNG or JPEG",
                                  oneLine(uri.substr(0, 60))));
        }
        return bytes;
    }
    const std::string decoded = percentDecoded(uri);
    const std::optional<fs::path> path = resolvedInside(file.parent_path(), decoded);
    if (!path) {
        failInput(file, pointer,
                  fmt::format("refers to '{}', outside its own folder", oneLine(decoded, 200)));
    }
    return readBytes(*path, decoded, file, pointer, budget);
}

}  // namespace penumbra::scene_detail
