#include "harness/gate/history.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <charconv>
#include <map>

#include "core/error.hpp"
#include "harness/gate/gated_metric.hpp"
#include "harness/run/csv.hpp"

namespace penumbra::gate {
namespace {

constexpr const char* kHeader =
    "when,who,commit,reason,renderer,threads,machine,baseline,scene,frame,setting,metric,before,"
    "after";
constexpr std::size_t kColumns = 14;

template <class Value>
Value number(const std::string& text, const std::string& at, const char* column) {
    Value value{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end)
        throw InputError(fmt::format("{}: column {}: '{}' is not a number", at, column, text));
    return value;
}

std::optional<double> value(const std::string& text, const std::string& at, const char* column) {
    return text.empty() ? std::nullopt : std::optional(number<double>(text, at, column));
}

std::string field(const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : "";
}

void addChanges(std::vector<Change>& changes, const Row& place, const Row* before,
                const Row* after) {
    const auto valueOf = [](const Row* row, const std::string& metric) {
        return row && row->status == "ok" ? numberInColumn(*row, metric) : std::nullopt;
    };
    for (const std::string& metric : historyMetrics()) {
        const auto then = valueOf(before, metric), now = valueOf(after, metric);
        if (then != now)
            changes.push_back({place.scene, place.frame, place.setting, metric, then, now});
    }
}

}  // namespace

const std::vector<std::string>& historyMetrics() {
    static const std::vector<std::string> kNames = [] {
        std::vector<std::string> names = {"frame_ms", "frame_ms_low", "frame_ms_high"};
        for (const GatedMetric& metric : gatedMetrics())
            if (metric.id != names.front()) names.emplace_back(metric.id);
        return names;
    }();
    return kNames;
}

std::string hashOf(std::string_view text) {
    return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

std::vector<Change> changesBetween(const std::vector<Row>& before, const std::vector<Row>& after) {
    std::map<std::string, const Row*> old;
    for (const Row& row : before) old[row.key()] = &row;
    std::vector<Change> changes;
    for (const Row& row : after) {
        const auto then = old.find(row.key());
        addChanges(changes, row, then == old.end() ? nullptr : then->second, &row);
        if (then != old.end()) old.erase(then);
    }
    for (const Row& row : before)
        if (old.contains(row.key())) addChanges(changes, row, &row, nullptr);
    return changes;
}

std::string historyText(const std::vector<Approval>& approvals) {
    std::string text = fmt::format("{}\n", kHeader);
    for (const Approval& a : approvals) {
        text += fmt::format("{},{},{},{},{},{},{},{},,,,,,\n", csvQuoted(a.when), csvQuoted(a.who),
                            csvQuoted(a.commit), csvQuoted(a.reason), csvQuoted(a.renderer),
                            a.threads, csvQuoted(a.machine), csvQuoted(a.baseline));
        for (const Change& c : a.changes)
            text += fmt::format(",,,,,,,,{},{},{},{},{},{}\n", csvQuoted(c.scene), c.frame,
                                csvQuoted(c.setting), csvQuoted(c.metric), field(c.before),
                                field(c.after));
    }
    return text;
}

std::vector<Approval> readHistory(const std::filesystem::path& file) {
    const std::string name = file.string(), text = readTextFile(file);
    const CsvRecords records = splitCsv(text, name);
    if (records.completeBytes != text.size())
        throw InputError(fmt::format("{}: the last line is cut short", name));
    std::vector<Approval> approvals;
    for (std::size_t i = 0; i < records.complete.size(); ++i) {
        const CsvRecord& record = records.complete[i];
        const std::string at = fmt::format("{}:{}", name, record.line);
        const std::vector<std::string>& f = record.fields;
        if (f.size() != kColumns || (i == 0 && fmt::format("{}", fmt::join(f, ",")) != kHeader))
            throw InputError(fmt::format("{}: the columns are {}", at, kHeader));
        if (i == 0) continue;
        if (!f[0].empty()) {
            approvals.push_back(
                {f[0], f[1], f[2], f[3], f[4], f[6], number<int>(f[5], at, "threads"), f[7], {}});
        } else if (approvals.empty()) {
            throw InputError(at + ": a change before the first approval");
        } else {
            approvals.back().changes.push_back({f[8], number<int>(f[9], at, "frame"), f[10], f[11],
                                                value(f[12], at, "before"),
                                                value(f[13], at, "after")});
        }
    }
    return approvals;
}

void dropUnborn(std::vector<Approval>& approvals, std::string_view baselineText) {
    if (approvals.empty()) return;
    const std::string now = hashOf(baselineText);
    if (approvals.back().baseline == now) return;
    const bool first = approvals.size() == 1;
    if (first ? baselineText.empty() : approvals[approvals.size() - 2].baseline == now)
        approvals.pop_back();
}

}  // namespace penumbra::gate
