#include "harness/study/claims_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "harness/run/csv.hpp"

namespace penumbra {
namespace {

std::string number(double value) {
    return std::isinf(value) ? "∞" : fmt::format("{:.3g}", value);
}

std::string measuredText(const ClaimResult& r) {
    if (!r.ratio) return r.verdict == Verdict::could_not_run ? "-" : "";
    if (r.ratio->isExact()) return number(r.ratio->value);
    return fmt::format("{} ({} to {})", number(r.ratio->value), number(r.ratio->low),
                       number(r.ratio->high));
}

std::string paperText(const ClaimResult& r) {
    if (r.verdict != Verdict::not_implemented) return r.claim.expected.text();
    return r.claim.expected.ratio ? number(*r.claim.expected.ratio) : "";
}

std::string numberField(const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : "";
}

/// "pcf:taps=9 on fence frame 1, light 2x"; what is as the script has it is left out.
std::string sideText(const ClaimSide& side) {
    std::string text = fmt::format("`{}` on {}", side.setting, side.scene);
    if (side.frame != 0) text += fmt::format(" frame {}", side.frame);
    if (side.variation.lightScale != 1.0)
        text += fmt::format(", light {:.3g} times as wide", side.variation.lightScale);
    if (side.variation.subdivisions != 0)
        text += fmt::format(", triangles cut in {}", 1 << (2 * side.variation.subdivisions));
    return text;
}

std::string cell(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '|' ? "\\|" : std::string(1, c);
    return out;
}

std::string details(const ClaimResult& r) {
    std::string text = fmt::format("- **{}** ({}): ", r.claim.id, r.claim.place);
    if (r.verdict == Verdict::not_implemented)
        return text + fmt::format("{} is not implemented here.\n", r.claim.technique);
    text += fmt::format("{} of {}", r.claim.metric, sideText(r.claim.a));
    if (r.a) text += fmt::format(" ({})", number(*r.a));
    text += " over that of " + sideText(r.claim.b);
    if (r.b) text += fmt::format(" ({})", number(*r.b));
    text += fmt::format(". {}", r.claim.why);
    if (r.verdict == Verdict::does_not_hold && !r.claim.found.empty())
        text += fmt::format(" **Found:** {}", r.claim.found);
    if (!r.message.empty()) text += fmt::format(" ({})", r.message);
    return text + "\n";
}

std::string countsText(const std::vector<ClaimResult>& results) {
    std::map<Verdict, int> counts;
    for (const ClaimResult& r : results) ++counts[r.verdict];
    std::vector<std::string> parts;
    for (const auto& [verdict, count] : counts)
        parts.push_back(fmt::format("{} {}", textOf(verdict), count));
    return fmt::format("{} claims: {}.", results.size(), fmt::join(parts, ", "));
}

}  // namespace

std::string claimsCsv(const std::vector<ClaimResult>& results) {
    std::string csv =
        "paper,id,claim,place,metric,a_setting,a_scene,a_frame,a_light_scale,a_subdivisions,"
        "b_setting,b_scene,b_frame,b_light_scale,b_subdivisions,paper_ratio,relation,a,b,ratio,"
        "ratio_low,ratio_high,verdict,message\n";
    for (const ClaimResult& r : results) {
        const Claim& c = r.claim;
        const bool implemented = r.verdict != Verdict::not_implemented;
        std::vector<std::string> fields{r.paper, c.id, c.statement, c.place, c.metric};
        for (const ClaimSide* side : {&c.a, &c.b})
            for (const std::string& field :
                 {side->setting, side->scene, fmt::format("{}", side->frame),
                  fmt::format("{}", side->variation.lightScale),
                  fmt::format("{}", side->variation.subdivisions)})
                fields.push_back(implemented ? field : "");
        fields.push_back(numberField(c.expected.ratio));
        fields.push_back(implemented ? c.expected.text() : "");
        fields.push_back(numberField(r.a));
        fields.push_back(numberField(r.b));
        fields.push_back(r.ratio ? numberField(r.ratio->value) : "");
        fields.push_back(r.ratio ? numberField(r.ratio->low) : "");
        fields.push_back(r.ratio ? numberField(r.ratio->high) : "");
        fields.emplace_back(textOf(r.verdict));
        fields.push_back(r.message);
        for (std::string& field : fields) field = csvQuoted(field);
        csv += fmt::format("{}\n", fmt::join(fields, ","));
    }
    return csv;
}

std::string claimsMarkdown(const std::vector<ClaimResult>& results,
                           const std::vector<std::string>& heading) {
    std::string page = fmt::format("{}\n\n{}\n", fmt::join(heading, "\n"), countsText(results));
    for (std::size_t begin = 0, end; begin < results.size(); begin = end) {
        end = begin;
        while (end < results.size() && results[end].paper == results[begin].paper) ++end;
        page += fmt::format("\n## {}\n\n{}\n\n", results[begin].paper, results[begin].citation);
        page += "| claim | paper | measured | verdict |\n| --- | --- | --- | --- |\n";
        for (std::size_t i = begin; i < end; ++i) {
            const ClaimResult& r = results[i];
            page +=
                fmt::format("| **{}**: {} | {} | {} | {} |\n", r.claim.id, cell(r.claim.statement),
                            paperText(r), measuredText(r), textOf(r.verdict));
        }
        page += "\n";
        for (std::size_t i = begin; i < end; ++i) page += details(results[i]);
    }
    return page;
}

std::string claimsText(const std::vector<ClaimResult>& results) {
    std::string text;
    for (const ClaimResult& r : results) {
        text += fmt::format("{:<50} paper {:<20} measured {:<24} {}\n", r.paper + " " + r.claim.id,
                            paperText(r), measuredText(r), textOf(r.verdict));
        if (!r.message.empty()) text += fmt::format("    {}\n", r.message);
        if (r.verdict == Verdict::does_not_hold && !r.claim.found.empty())
            text += fmt::format("    {}\n", r.claim.found);
    }
    return text + countsText(results) + "\n";
}

}  // namespace penumbra
