#include "core/gl/shader_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "core/gl/program.hpp"

namespace penumbra::gl {
namespace {

/// Files are told apart by ranges of line numbers: file n has lines from n times this on. GLSL has
/// source-string numbers for it, but Mesa reports 0 for most of them.
constexpr int kLinesPerFile = 100000;

std::string lineDirective(std::size_t file, int line) {
    return fmt::format("#line {}\n", static_cast<int>(file) * kLinesPerFile + line);
}

std::string readFile(const std::string& file, const std::string& includedFrom) {
    const std::filesystem::path path = shaderFolder() / file;
    std::ifstream stream(path);
    if (!stream || !std::filesystem::is_regular_file(path))
        throw std::runtime_error(includedFrom + "there is no shader " + path.string());
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Removes leading blanks and then `token` from `text`; false, and `text` unchanged, if it is not
/// there.
bool eat(std::string_view& text, std::string_view token) {
    const std::size_t begin = std::min(text.find_first_not_of(" \t\r"), text.size());
    if (!text.substr(begin).starts_with(token)) return false;
    text.remove_prefix(begin + token.size());
    return true;
}

/// The file that an include line names: nullopt if `line` is none, "" if it names none.
std::optional<std::string> includedFile(std::string_view line) {
    if (!eat(line, "#") || !eat(line, "include")) return std::nullopt;
    if (!eat(line, "\"")) return "";
    const std::size_t end = line.find('"');
    if (end == std::string_view::npos) return "";
    const std::string file(line.substr(0, end));
    line.remove_prefix(end + 1);
    eat(line, "");
    return line.empty() || line.starts_with("//") ? file : "";
}

/// Writes one file and, in place of its include lines, the files they name. Every inclusion is put
/// between guards rather than left out the second time: the first may lie in a branch that the
/// GLSL preprocessor skips.
class Expander {
  public:
    explicit Expander(ShaderSource& source) : source_(source) {}

    void expand(const std::string& file, const std::string& includedFrom) {
        const std::string text = readFile(file, includedFrom);
        const std::size_t number = numberOf(file);
        open_.push_back(file);
        source_.text += lineDirective(number, 1);
        std::istringstream lines(text);
        std::string line;
        for (int lineNumber = 1; std::getline(lines, line); ++lineNumber) {
            const std::optional<std::string> included = includedFile(line);
            if (!included) {
                source_.text += line + '\n';
                continue;
            }
            const std::string here = fmt::format("{}:{}: ", file, lineNumber);
            if (included->empty())
                throw std::runtime_error(here + "expected #include \"common/<name>.glsl\"");
            include(*included, here);
            source_.text += lineDirective(number, lineNumber + 1);
        }
        open_.pop_back();
    }

  private:
    void include(const std::string& file, const std::string& includedFrom) {
        if (std::ranges::find(open_, file) != open_.end()) return;  // its guard is already defined
        const std::size_t number = numberOf(file);
        source_.text +=
            fmt::format("#ifndef PENUMBRA_INCLUDED_{0}\n#define PENUMBRA_INCLUDED_{0}\n", number);
        expand(file, includedFrom);
        source_.text += "#endif\n";
    }

    std::size_t numberOf(const std::string& file) {
        const auto at = std::ranges::find(source_.files, file);
        const std::size_t number = static_cast<std::size_t>(at - source_.files.begin());
        if (at == source_.files.end()) source_.files.push_back(file);
        return number;
    }

    ShaderSource& source_;
    std::vector<std::string> open_;
};

}  // namespace

ShaderSource readShader(const std::string& file, const std::string& stage,
                        const std::vector<std::string>& defines) {
    ShaderSource source;
    source.files.push_back("(defines of " + file + ")");
    source.text = "#version 450 core\n#define STAGE_" + stage + "\n";
    for (const std::string& define : defines) source.text += "#define " + define + '\n';
    Expander(source).expand(file, "");
    return source;
}

std::string ShaderSource::mapLog(const std::string& log) const {
    std::istringstream lines(log);
    std::string mapped, line;
    while (std::getline(lines, line)) {
        // Mesa: "0:12(5): error: …", NVIDIA: "0(12) : error …", glslang and AMD: "ERROR: 0:12: …".
        std::string_view rest = line;
        const std::string_view kind = eat(rest, "ERROR: ")     ? "ERROR: "
                                      : eat(rest, "WARNING: ") ? "WARNING: "
                                                               : "";
        int number = 0;
        if (eat(rest, "0:") || eat(rest, "0(")) {
            const char* end = rest.data() + rest.size();
            auto [stop, error] = std::from_chars(rest.data(), end, number);
            if (rest.data()[-1] == '(' && stop != end) ++stop;  // NVIDIA's closing parenthesis
            const auto file = static_cast<std::size_t>(number) / kLinesPerFile;
            if (error == std::errc{} && number >= 0 && file < files.size())
                line = fmt::format("{}{}:{}{}", kind, files[file], number % kLinesPerFile,
                                   std::string_view(stop, static_cast<std::size_t>(end - stop)));
        }
        mapped += (mapped.empty() ? "" : "\n") + line;
    }
    return mapped;
}

}  // namespace penumbra::gl
