#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace penumbra::stress {

/// A table of a TOML file whose every key must be asked for: typed values, and one-line errors
/// "file:line: what; valid choices" as InputError.
class TomlTable {
  public:
    /// Reads a file. Throws InputError.
    static TomlTable read(const std::filesystem::path& file);

    bool has(const std::string& key) const { return table_->contains(key); }
    std::string text(const std::string& key);
    bool flag(const std::string& key, bool fallback);
    double number(const std::string& key, double lo = -std::numeric_limits<double>::infinity(),
                  double hi = std::numeric_limits<double>::infinity());
    double number(const std::string& key, double fallback, double lo, double hi);
    /// A number or a list of numbers; `count` of them, or any number of them where it is 0.
    std::vector<double> numbers(const std::string& key, std::size_t count = 0);
    glm::dvec3 vector(const std::string& key);
    std::vector<std::string> texts(const std::string& key);
    TomlTable table(const std::string& key);
    /// [[key]]; none where the key is absent.
    std::vector<TomlTable> tables(const std::string& key);
    /// Every key with its value as text, numbers and booleans included.
    std::vector<std::pair<std::string, std::string>> assignments();

    /// Throws InputError if a key was never asked for, naming those that were.
    void finish() const;
    /// Throws InputError at `key`, or at the table itself.
    [[noreturn]] void fail(const std::string& key, const std::string& what) const;
    int lineOf(const std::string& key) const;
    std::string place(const std::string& key) const;  ///< "file:line"

  private:
    TomlTable(std::filesystem::path file, std::string name,
              std::shared_ptr<const toml::table> table)
        : file_(std::move(file)), name_(std::move(name)), table_(std::move(table)) {}
    const toml::node& required(const std::string& key);

    std::filesystem::path file_;
    std::string name_;                          ///< as in "[light]"
    std::shared_ptr<const toml::table> table_;  ///< of the whole file: copies forget their lines
    std::vector<std::string> asked_;
};

}  // namespace penumbra::stress
