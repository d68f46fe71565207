#include "harness/gate/gate_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "harness/report/escape.hpp"
#include "harness/report/markdown.hpp"
#include "harness/run/command_line.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra::gate {
namespace {

/// GitHub drops what a step says beyond these.
constexpr std::size_t kMostAnnotations = 10;
/// So many failing gates are told in full in summary.md; all are in junit.xml.
constexpr std::size_t kMostInMarkdown = 50;

std::string title(const Gate& gate) {
    return fmt::format("{}: {}", gate.place(), nameOf(gate.kind));
}

/// Pictures of the row that are in the run folder.
std::vector<std::string> pictures(const Gate& gate, const JudgedRun& run) {
    const RunFolder folder(run.folder);
    std::vector<std::string> paths;
    for (const std::filesystem::path& path :
         {folder.grid(gate.row.scene),
          folder.setting(gate.row.scene, gate.row.frame, gate.row.setting)})
        if (std::filesystem::exists(path)) paths.push_back(path.string());
    return paths;
}

struct Line {
    std::string_view name;
    std::string text;
};

/// What a failure says, line by line.
std::vector<Line> details(const Gate& gate, const JudgedRun& run) {
    std::vector<Line> lines;
    for (const Finding& f : gate.findings)
        lines.push_back({f.metric, fmt::format("{}; {}", f.change, f.limit)});
    if (const auto paths = pictures(gate, run); !paths.empty())
        lines.push_back({"look at", fmt::format("{}", fmt::join(paths, ", "))});
    lines.push_back({"run", reproducingCommand(run.record, gate.row)});
    if (!gate.again.empty()) lines.push_back({"re-measured", gate.again});
    return lines;
}

/// Of a gate that did not simply pass or fail.
std::string remarkOn(const Gate& gate) {
    return gate.again.empty() ? gate.note : "re-measured: " + gate.again;
}

std::string plural(std::size_t count, const char* thing) {
    return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string counts(const Verdict& verdict) {
    std::string text = plural(verdict.gates.size(), "gate");
    const auto add = [&](State state, const char* what) {
        if (const std::size_t n = verdict.count(state); n > 0)
            text += fmt::format(", {} {}", n, what);
    };
    add(State::passed, "passed");
    add(State::failed, "failed");
    add(State::recovered, "passed when measured again");
    add(State::missing, "missing");
    add(State::missingKnown, "missing as gates.toml lets them");
    add(State::added, "new");
    return text;
}

/// What is neither pass nor fail: one line each.
std::vector<std::string> remarks(const Verdict& verdict) {
    std::vector<std::string> lines = verdict.notes;
    if (verdict.timeRatios.size() > 1)
        lines.push_back(
            fmt::format("{} rows compared in time: the median is {:.3g} times the baseline's",
                        verdict.timeRatios.size(), median(verdict.timeRatios)));
    if (verdict.improvements > 0)
        lines.push_back(
            fmt::format("{} better by more than their limit: `penumbra approve` would "
                        "make that the baseline",
                        plural(verdict.improvements, "metric")));
    return lines;
}

std::string sentence(const Verdict& verdict) {
    return fmt::format("{}: {}", verdict.fails() ? "the gate fails" : "the gate passes",
                       counts(verdict));
}

std::string code(const std::string& text) {
    return "<code>" + markdown::escaped(printable(text)) + "</code>";
}

}  // namespace

std::string verdictText(const Verdict& verdict, const JudgedRun& run) {
    std::string text;
    for (const std::string& remark : remarks(verdict))
        text += fmt::format("note: {}\n", printable(remark));
    for (const Gate& gate : verdict.gates) {
        if (gate.fails()) {
            text += fmt::format("{} {}\n", gate.state == State::missing ? "MISSING" : "FAIL",
                                printable(title(gate)));
            for (const Line& line : details(gate, run))
                text += fmt::format("    {} {}\n", line.name, printable(line.text));
        } else if (gate.state == State::recovered) {
            text += fmt::format("recovered {}\n    re-measured {}\n", printable(title(gate)),
                                printable(gate.again));
        } else if (gate.state == State::added || gate.state == State::missingKnown) {
            text += fmt::format("{} {}: {}\n", gate.state == State::added ? "new" : "missing",
                                printable(gate.place()), printable(gate.note));
        }
    }
    return text + sentence(verdict) + "\n";
}

std::string verdictMarkdown(const Verdict& verdict, const JudgedRun& run) {
    std::string text = fmt::format("# Gate\n\n**{}**\n\n", sentence(verdict));
    for (const std::string& remark : remarks(verdict))
        text += fmt::format("- {}\n", markdown::escaped(printable(remark)));
    if (text.ends_with("\n") && !text.ends_with("\n\n")) text += '\n';

    std::vector<markdown::Cells> lines;
    std::vector<std::string> others;
    for (const Gate& gate : verdict.gates) {
        const std::string where = markdown::escaped(printable(gate.place()));
        if (gate.fails()) {
            std::string what, how;
            for (const Line& line : details(gate, run)) {
                const bool finding = line.name != "run" && line.name != "look at";
                std::string& cell = finding ? what : how;
                if (!cell.empty()) cell += "<br>";
                cell += fmt::format(
                    "{} {}", markdown::escaped(line.name),
                    line.name == "run" ? code(line.text) : markdown::escaped(printable(line.text)));
            }
            lines.push_back({where, std::string(nameOf(gate.kind)), what, how});
        } else if (gate.state != State::passed) {
            others.push_back(fmt::format("- {}: {}: {}\n", where, nameOf(gate.kind),
                                         markdown::escaped(printable(remarkOn(gate)))));
        }
    }
    const std::size_t failing = lines.size();
    lines.resize(std::min(failing, kMostInMarkdown));
    if (!lines.empty()) text += markdown::table({"where", "gate", "what", "how"}, 4, lines);
    if (failing > lines.size())
        text += fmt::format("… and {} more in junit.xml\n\n", failing - lines.size());
    for (const std::string& line : others) text += line;
    return text;
}

std::string verdictJunit(const Verdict& verdict, const JudgedRun& run) {
    std::size_t failures = 0;
    for (const Gate& gate : verdict.gates) failures += gate.fails();
    std::string text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"penumbra\" "
        "tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n",
        verdict.gates.size(), failures,
        verdict.count(State::added) + verdict.count(State::missingKnown));
    for (const Gate& gate : verdict.gates) {
        text += fmt::format("<testcase classname=\"{}\" name=\"{}\"",
                            xmlEscaped(gate.row.scene + "." + gate.row.method),
                            xmlEscaped(title(gate)));
        if (gate.fails()) {
            const Finding& worst = gate.findings.front();
            std::string body;
            for (const Line& line : details(gate, run))
                body += fmt::format("{} {}\n", line.name, line.text);
            text += fmt::format("><failure type=\"{}\" message=\"{}\">{}</failure></testcase>\n",
                                gate.state == State::missing ? "missing" : "regression",
                                xmlEscaped(worst.metric + " " + worst.change), xmlEscaped(body));
        } else if (gate.state == State::added || gate.state == State::missingKnown) {
            text += fmt::format("><skipped message=\"{}\"/></testcase>\n", xmlEscaped(gate.note));
        } else if (gate.state == State::recovered) {
            text +=
                fmt::format("><system-out>{}</system-out></testcase>\n", xmlEscaped(gate.again));
        } else {
            text += "/>\n";
        }
    }
    return text + "</testsuite>\n</testsuites>\n";
}

std::string verdictAnnotations(const Verdict& verdict, const JudgedRun& run) {
    std::string text;
    std::size_t failing = 0;
    for (const Gate& gate : verdict.gates) failing += gate.fails();
    std::size_t told = 0;
    for (const Gate& gate : verdict.gates) {
        if (!gate.fails()) continue;
        if (++told == kMostAnnotations && failing > kMostAnnotations)
            return text + fmt::format("::error title=penumbra::and {} more, see junit.xml\n",
                                      failing - kMostAnnotations + 1);
        std::string message;
        for (const Line& line : details(gate, run))
            message += fmt::format("{}{} {}", message.empty() ? "" : "\n", line.name, line.text);
        text += fmt::format("::error title={}::{}\n", commandProperty(title(gate)),
                            commandData(message));
    }
    return text;
}

}  // namespace penumbra::gate
