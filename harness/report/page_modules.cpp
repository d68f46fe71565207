#include "harness/report/page_modules.hpp"

#include <fmt/format.h>

#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "harness/run/csv.hpp"

namespace penumbra {
namespace {

class Joiner {
  public:
    explicit Joiner(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Adds what is not there yet and returns the variable that holds the module's exports.
    std::string add(const std::string& name) {
        const auto [module, isNew] =
            modules_.try_emplace(name, fmt::format("module{}", modules_.size()));
        if (!isNew) return module->second;
        static const std::regex kImport(
            R"re(import (\{[\w\s,$]*\}) from "\./([\w./-]+\.js)";\s*)re");
        static const std::regex kExport(
            R"(export ((?:(?:async )?function|class|const|let) ([\w$]+).*))");
        std::istringstream lines(readTextFile(folder_ / name));
        std::string body, line, statement, exports;
        for (int number = 1; std::getline(lines, line); ++number) {
            const std::string where = fmt::format("{}:{}: ", name, number);
            std::smatch match;
            if (!statement.empty() || line.starts_with("import")) {
                statement += line + '\n';
                if (line.find(';') == std::string::npos) continue;
                if (!std::regex_match(statement, match, kImport))
                    throw std::runtime_error(where + "expected import {a, b} from \"./name.js\";");
                body += fmt::format("const {} = {};\n", match.str(1), add(match[2]));
                statement.clear();
            } else if (line.starts_with("export")) {
                if (!std::regex_match(line, match, kExport))
                    throw std::runtime_error(where + "expected export before a declaration");
                body += match.str(1) + '\n';
                exports += (exports.empty() ? "" : ", ") + match.str(2);
            } else {
                body += line + '\n';
            }
        }
        if (!statement.empty())
            throw std::runtime_error(fmt::format("{}: an import without its end", name));
        joined_ += fmt::format("// ---- {} ----\nconst {} = (() => {{\n{}return {{{}}};\n}})();\n",
                               name, module->second, body, exports);
        return module->second;
    }

    std::string joined() && { return std::move(joined_); }

  private:
    std::filesystem::path folder_;
    std::map<std::string, std::string> modules_;  ///< variable by file
    std::string joined_;
};

}  // namespace

std::string joinModules(const std::filesystem::path& folder, const std::string& entry) {
    Joiner joiner(folder);
    joiner.add(entry);
    return std::move(joiner).joined();
}

}  // namespace penumbra
