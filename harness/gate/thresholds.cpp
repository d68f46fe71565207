#include "harness/gate/thresholds.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace penumbra::gate {
namespace {

const std::vector<std::string> kKeys = {"scene",    "method", "metric", "relative",
                                        "absolute", "ignore", "reason"};

std::vector<std::string_view> metricIds() {
    std::vector<std::string_view> ids;
    for (const GatedMetric& metric : gatedMetrics()) ids.push_back(metric.id);
    return ids;
}

bool namesSomething(const std::string& pattern) {
    return pattern == kRow || pattern == kEffectsMissing ||
           std::ranges::any_of(metricIds(), [&](auto id) { return matchesGlob(pattern, id); });
}

class Reader {
  public:
    explicit Reader(const std::filesystem::path& file) : file_(file) {}

    [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
        throw InputError(fmt::format("{}:{}: {}", file_.string(),
                                     std::max<unsigned>(node.source().begin.line, 1), what));
    }

    toml::table root() const {
        try {
            return toml::parse_file(file_.string());
        } catch (const toml::parse_error& e) {
            throw InputError(
                fmt::format("{}:{}: {}", file_.string(), e.source().begin.line, e.description()));
        }
    }

    void checkKeys(const toml::table& table, const std::vector<std::string>& valid) const {
        for (const auto& [key, node] : table)
            if (std::ranges::find(valid, key.str()) == valid.end())
                fail(node, fmt::format("unknown key '{}'; valid keys are {}", key.str(),
                                       fmt::join(valid, ", ")));
    }

    std::string text(const toml::table& table, const char* key, const std::string& absent) const {
        const toml::node* node = table.get(key);
        if (!node) return absent;
        const auto value = node->value_exact<std::string>();
        if (!value || value->find_first_not_of(" \t\r\n") == std::string::npos)
            fail(*node, fmt::format("{} must be a text that is not empty", key));
        return *value;
    }

    double fraction(const toml::table& table, const char* key) const {
        const toml::node* node = table.get(key);
        if (!node) return 0.0;
        const auto value = node->value<double>();
        if (!node->is_number() || !std::isfinite(*value) || *value < 0.0)
            fail(*node, fmt::format("{} must be a finite number, 0 or more", key));
        return *value;
    }

    Threshold threshold(const toml::table& table, const std::string& metric) const {
        Threshold out{fraction(table, "relative"), fraction(table, "absolute"), false,
                      text(table, "reason", "")};
        if (out.reason.empty()) fail(table, "'reason' is missing: say why this may change");
        const bool numbers = table.contains("relative") || table.contains("absolute");
        if (const toml::node* ignore = table.get("ignore")) {
            if (ignore->value_exact<bool>() != true) fail(*ignore, "ignore must be true");
            if (numbers) fail(*ignore, "ignore leaves nothing to compare with a threshold");
            out.ignored = true;
        } else if (metric == kRow || metric == kEffectsMissing) {
            fail(table, fmt::format("metric \"{}\" is no number: it takes ignore = true", metric));
        } else if (!numbers) {
            fail(table, "one of relative, absolute and ignore is needed");
        }
        return out;
    }

  private:
    const std::filesystem::path& file_;
};

}  // namespace

bool matchesGlob(std::string_view pattern, std::string_view text) {
    std::size_t p = 0, t = 0;
    // Where to go on if what follows the last * does not match: one more character is the star's.
    std::size_t afterStar = std::string_view::npos, starEnd = 0;
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            afterStar = ++p;
            starEnd = t;
        } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
            ++p, ++t;
        } else if (afterStar != std::string_view::npos) {
            p = afterStar;
            t = ++starEnd;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

Thresholds Thresholds::read(const std::filesystem::path& file) {
    const Reader reader(file);
    const toml::table root = reader.root();
    reader.checkKeys(root, {"gate"});
    Thresholds thresholds;
    const toml::node* gates = root.get("gate");
    if (!gates) return thresholds;
    if (!gates->is_array_of_tables()) reader.fail(*gates, "rules are written as [[gate]]");
    for (const toml::node& node : *gates->as_array()) {
        const toml::table& table = *node.as_table();
        reader.checkKeys(table, kKeys);
        Rule rule;
        rule.scene = reader.text(table, "scene", "*");
        rule.method = reader.text(table, "method", "*");
        rule.metric = reader.text(table, "metric", "");
        if (rule.metric.empty()) reader.fail(table, "'metric' is missing");
        if (!namesSomething(rule.metric))
            reader.fail(*table.get("metric"),
                        fmt::format("no metric is called '{}'; valid are {}, {}, {}", rule.metric,
                                    fmt::join(metricIds(), ", "), kRow, kEffectsMissing));
        rule.threshold = reader.threshold(table, rule.metric);
        thresholds.rules_.push_back(std::move(rule));
    }
    return thresholds;
}

template <class MatchesMetric>
const Thresholds::Rule* Thresholds::lastMatching(const Row& row,
                                                 const MatchesMetric& matchesMetric) const {
    const auto found = std::find_if(rules_.rbegin(), rules_.rend(), [&](const Rule& rule) {
        return matchesMetric(rule.metric) && matchesGlob(rule.scene, row.scene) &&
               (matchesGlob(rule.method, row.method) || matchesGlob(rule.method, row.setting));
    });
    return found == rules_.rend() ? nullptr : &*found;
}

Threshold Thresholds::of(const GatedMetric& metric, const Row& row) const {
    const Rule* rule = lastMatching(
        row, [&](const std::string& pattern) { return matchesGlob(pattern, metric.id); });
    return rule ? rule->threshold : metric.threshold();
}

Threshold Thresholds::of(std::string_view state, const Row& row) const {
    // A pattern of many metrics is about numbers: whoever lets rows vanish says so by name.
    const Rule* rule =
        lastMatching(row, [&](const std::string& pattern) { return pattern == state; });
    return rule ? rule->threshold : Threshold{};
}

}  // namespace penumbra::gate
