#include "harness/gate/baseline.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/run_folder.hpp"

namespace penumbra::gate {
namespace {

constexpr const char* kMachineColumn = "machine";

}  // namespace

std::string machineOf(const RunRecord& record) {
    const std::string cpu = record.provenanceOf("cpu"), build = record.provenanceOf("build");
    return cpu.empty() || build.empty() ? "" : fmt::format("{}, {}", cpu, build);
}

Baseline readBaseline(const std::filesystem::path& file) {
    Baseline baseline{file, readResultsTable(file), {}};
    const auto column = baseline.table.unknown.find(kMachineColumn);
    if (column != baseline.table.unknown.end()) {
        baseline.machines = std::move(column->second);
        baseline.table.unknown.erase(column);
        return baseline;
    }
    const std::filesystem::path record = RunFolder(file.parent_path()).record();
    const std::string machine =
        std::filesystem::exists(record) ? machineOf(RunRecord::read(record)) : "";
    baseline.machines.assign(baseline.table.rows.size(), machine);
    return baseline;
}

std::string baselineText(const std::vector<Row>& rows, const std::string& machine) {
    std::string text = fmt::format("{},{}\n", csvHeader(), kMachineColumn);
    for (const Row& row : rows) text += fmt::format("{},{}\n", toCsv(row), csvQuoted(machine));
    return text;
}

}  // namespace penumbra::gate
