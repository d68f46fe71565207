#include "harness/study/stress/toml_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::stress {

TomlTable TomlTable::read(const std::filesystem::path& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        scene_detail::failInput(file, "", "is not a readable file");
    try {
        return TomlTable(file, "the file",
                         std::make_shared<const toml::table>(toml::parse_file(file.string())));
    } catch (const toml::parse_error& e) {
        throw InputError(scene_detail::oneLine(
            fmt::format("{}:{}: {}", file.string(), e.source().begin.line, e.description())));
    }
}

int TomlTable::lineOf(const std::string& key) const {
    const toml::node* node = table_->get(key);
    const auto line = (node ? node->source() : table_->source()).begin.line;
    return std::max(1, static_cast<int>(line));
}

std::string TomlTable::place(const std::string& key) const {
    return fmt::format("{}:{}", file_.string(), lineOf(key));
}

void TomlTable::fail(const std::string& key, const std::string& what) const {
    throw InputError(scene_detail::oneLine(fmt::format("{}: {}", place(key), what), 2000));
}

const toml::node& TomlTable::required(const std::string& key) {
    if (std::ranges::find(asked_, key) == asked_.end()) asked_.push_back(key);
    const toml::node* node = table_->get(key);
    if (!node) fail(key, fmt::format("{} needs '{}'", name_, key));
    return *node;
}

std::string TomlTable::text(const std::string& key) {
    const toml::node& node = required(key);
    if (!node.is_string() || node.as_string()->get().empty())
        fail(key, fmt::format("{} must be a string with something in it", key));
    return node.as_string()->get();
}

bool TomlTable::flag(const std::string& key, bool fallback) {
    asked_.push_back(key);
    if (!has(key)) return fallback;
    const toml::node& node = required(key);
    if (!node.is_boolean()) fail(key, fmt::format("{} must be true or false", key));
    return node.as_boolean()->get();
}

double TomlTable::number(const std::string& key, double lo, double hi) {
    const double value = numbers(key, 1)[0];
    if (!(value >= lo && value <= hi)) fail(key, fmt::format("{} must be {} to {}", key, lo, hi));
    return value;
}

double TomlTable::number(const std::string& key, double fallback, double lo, double hi) {
    asked_.push_back(key);
    return has(key) ? number(key, lo, hi) : fallback;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count) {
    const toml::node& node = required(key);
    std::vector<double> values;
    const auto add = [&](const toml::node& element) {
        const auto value = element.is_number() ? element.value<double>() : std::nullopt;
        if (!value || !std::isfinite(*value))
            fail(key, fmt::format("{} must hold finite numbers", key));
        values.push_back(*value);
    };
    if (const toml::array* list = node.as_array())
        for (const toml::node& element : *list) add(element);
    else
        add(node);
    if (values.empty() || (count > 0 && values.size() != count))
        fail(key, fmt::format("{} must be {} number{}", key,
                              count > 0 ? std::to_string(count) : "a", count > 1 ? "s" : ""));
    return values;
}

glm::dvec3 TomlTable::vector(const std::string& key) {
    const std::vector<double> v = numbers(key, 3);
    return {v[0], v[1], v[2]};
}

std::vector<std::string> TomlTable::texts(const std::string& key) {
    std::vector<std::string> values;
    const toml::array* list = required(key).as_array();
    if (!list) fail(key, fmt::format("{} must be a list of strings", key));
    for (const toml::node& element : *list) {
        if (!element.is_string()) fail(key, fmt::format("{} must be a list of strings", key));
        values.push_back(element.as_string()->get());
    }
    return values;
}

TomlTable TomlTable::table(const std::string& key) {
    const toml::node& node = required(key);
    if (!node.is_table()) fail(key, fmt::format("'{0}' must be a table, [{0}]", key));
    return TomlTable(file_, "[" + key + "]", {table_, node.as_table()});
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
    asked_.push_back(key);
    std::vector<TomlTable> list;
    if (!has(key)) return list;
    const toml::array* array = required(key).as_array();
    if (!array || !array->is_array_of_tables())
        fail(key, fmt::format("'{0}' is written as [[{0}]]", key));
    for (const toml::node& element : *array)
        list.push_back(TomlTable(file_, "[[" + key + "]]", {table_, element.as_table()}));
    return list;
}

std::vector<std::pair<std::string, std::string>> TomlTable::assignments() {
    std::vector<std::pair<std::string, std::string>> list;
    for (const auto& [name, node] : *table_) {
        const std::string key(name.str());
        asked_.push_back(key);
        if (node.is_string())
            list.emplace_back(key, node.as_string()->get());
        else if (node.is_boolean())
            list.emplace_back(key, node.as_boolean()->get() ? "true" : "false");
        else if (node.is_number())
            list.emplace_back(key, fmt::format("{}", *node.value<double>()));
        else
            fail(key, fmt::format("{} must be a string, a number or true or false", key));
    }
    return list;
}

void TomlTable::finish() const {
    for (const auto& [name, node] : *table_) {
        const std::string key(name.str());
        if (std::ranges::find(asked_, key) != asked_.end()) continue;
        std::vector<std::string> valid = asked_;
        std::ranges::sort(valid);
        valid.erase(std::unique(valid.begin(), valid.end()), valid.end());
        fail(key, fmt::format("unknown key '{}' in {}; valid are {}",
                              scene_detail::oneLine(key, 60), name_, scene_detail::listed(valid)));
    }
}

}  // namespace penumbra::stress
