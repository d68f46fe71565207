#include "harness/study/effects_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "core/error.hpp"
#include "harness/report/markdown.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"

namespace penumbra {

using namespace markdown;

namespace {

constexpr const char* kHeader =
    "scene,frame,method,setting,plan,status,frame_ms,frame_ms_low,frame_ms_high,rmse_to_auto,"
    "max_to_auto,rmse\n";
constexpr std::size_t kColumns = 12;
constexpr const char *kAuto = "auto", *kAll = "all";

std::string field(const Number& value) {
    return value ? fmt::format("{}", *value) : "";
}

bool parse(const std::string& text, int& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

bool parse(const std::string& text, Number& value) {
    if (text.empty()) return true;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), value.emplace());
    return error == std::errc() && end == text.data() + text.size();
}

/// Differences over the scored pixels.
void compareToAuto(EffectsCell& cell, const std::vector<float>& image,
                   const std::vector<float>& autoImage, const GBuffer& gbuffer) {
    double squares = 0.0, most = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored) continue;
        const double difference = std::abs(double{image[i]} - double{autoImage[i]});
        squares += difference * difference;
        most = std::max(most, difference);
        ++count;
    }
    if (count == 0) return;
    cell.rmseToAuto = std::sqrt(squares / static_cast<double>(count));
    cell.maxToAuto = most;
}

EffectsCell cellOf(const Row& row, const std::string& plan) {
    EffectsCell cell;
    cell.scene = row.scene;
    cell.frame = row.frame;
    cell.method = row.method;
    cell.setting = row.setting;
    cell.plan = plan;
    cell.status = row.status;
    cell.frameMs = row.frameMs;
    cell.frameMsLow = row.frameMsLow;
    cell.frameMsHigh = row.frameMsHigh;
    return cell;
}

/// Sums over the frames in which both plans were timed.
struct Totals {
    double allMs = 0.0, autoMs = 0.0, most = 0.0;
    std::size_t frames = 0;

    void add(const EffectsCell& all, const EffectsCell& automatic) {
        if (!all.frameMs || !automatic.frameMs) return;
        allMs += *all.frameMs;
        autoMs += *automatic.frameMs;
        most = std::max(most, all.maxToAuto.value_or(0.0));
        ++frames;
    }
    Cells line(const std::string& name) const {
        return {name,           fmt::format("{}", frames),    number(allMs),
                number(autoMs), number(ratio(autoMs, allMs)), number(most)};
    }
};

/// What leaving one effect out of one setting's plans does, over the frames that call for it.
struct LeftOut {
    double autoMs = 0.0, withoutMs = 0.0, squares = 0.0, most = 0.0;
    std::size_t frames = 0;

    void add(const EffectsCell& automatic, const EffectsCell& without) {
        if (!automatic.frameMs || !without.frameMs) return;
        autoMs += *automatic.frameMs;
        withoutMs += *without.frameMs;
        const double rmse = without.rmseToAuto.value_or(0.0);
        squares += rmse * rmse;
        most = std::max(most, without.maxToAuto.value_or(0.0));
        ++frames;
    }
    Cells line(const std::string& setting, const std::string& effect) const {
        return {setting,
                effect,
                fmt::format("{}", frames),
                number(ratio(withoutMs, autoMs)),
                number(frames ? Number(std::sqrt(squares / static_cast<double>(frames)))
                              : std::nullopt),
                number(most)};
    }
};

using Group = std::vector<const EffectsCell*>;  // of one scene, frame and setting

std::vector<Group> grouped(const std::vector<EffectsCell>& cells) {
    std::vector<Group> groups;
    const auto key = [](const EffectsCell& c) { return std::tie(c.scene, c.frame, c.setting); };
    for (const EffectsCell& cell : cells) {
        const auto at = std::ranges::find_if(
            groups, [&](const Group& g) { return key(*g.front()) == key(cell); });
        if (at == groups.end())
            groups.push_back({&cell});
        else
            at->push_back(&cell);
    }
    return groups;
}

const EffectsCell* withPlan(const Group& group, std::string_view plan) {
    const auto at = std::ranges::find(group, plan, [](const EffectsCell* c) { return c->plan; });
    return at == group.end() ? nullptr : *at;
}

std::string planInWords(const std::string& plan) {
    return plan.starts_with('-') ? "auto without " + plan.substr(1) : plan;
}

}  // namespace

std::vector<PlanVariant> planVariants(const EffectSet& calledFor, const EffectSet& canSimulate) {
    std::vector<PlanVariant> variants = {{kAll, EffectChoice::parse("all")}};
    for (const EffectInfo& info : allEffects()) {
        if (!(calledFor & canSimulate).has(info.effect)) continue;
        EffectChoice choice;
        choice.leftOut.add(info.effect);
        variants.push_back({"-" + std::string(info.id), choice});
    }
    return variants;
}

std::vector<VariantImage> runVariants(
    const Frame& frame, const CellOptions& options, const std::vector<SettingRun*>& runs,
    const TextureTarget& target,
    const std::function<void(std::size_t, Row&&, const std::vector<float>&)>& done) {
    struct Variant {
        std::size_t of;  ///< index into `runs`
        std::string plan;
    };
    std::vector<Variant> variants;
    std::vector<SettingRun*> every = runs;
    std::vector<std::unique_ptr<SettingRun>> own;
    for (std::size_t r = 0; r < runs.size(); ++r) variants.push_back({r, kAuto});
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const Setting& setting = runs[r]->setting();
        const EffectSet canSimulate = setting.make()->traits().simulates;
        for (const PlanVariant& variant : planVariants(options.calledFor, canSimulate)) {
            own.push_back(std::make_unique<SettingRun>(setting, variant.choice));
            every.push_back(own.back().get());
            variants.push_back({r, variant.name});
        }
    }
    std::vector<VariantImage> images(variants.size());
    runCells(frame, options, every, target,
             [&](std::size_t run, Row&& row, const std::vector<float>& visibility) {
                 images[run] = {cellOf(row, variants[run].plan), visibility};
                 if (run < runs.size()) done(run, std::move(row), visibility);
             });
    for (std::size_t v = 0; v < images.size(); ++v) {
        const std::vector<float>& automatic = images[variants[v].of].visibility;
        if (!images[v].visibility.empty() && !automatic.empty())
            compareToAuto(images[v].cell, images[v].visibility, automatic, frame.gbuffer);
    }
    std::vector<VariantImage> ordered;
    for (std::size_t r = 0; r < runs.size(); ++r)
        for (std::size_t v = 0; v < images.size(); ++v)
            if (variants[v].of == r) ordered.push_back(std::move(images[v]));
    return ordered;
}

void writeEffectsCsv(const std::filesystem::path& path, const std::vector<EffectsCell>& cells) {
    std::string text = kHeader;
    for (const EffectsCell& c : cells)
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", csvQuoted(c.scene), c.frame,
                            csvQuoted(c.method), csvQuoted(c.setting), c.plan, c.status,
                            field(c.frameMs), field(c.frameMsLow), field(c.frameMsHigh),
                            field(c.rmseToAuto), field(c.maxToAuto), field(c.rmse));
    writeFileAtomically(path, text);
}

std::vector<EffectsCell> readEffectsCsv(const std::filesystem::path& path) {
    const std::string text = readTextFile(path);
    if (!text.starts_with(kHeader))
        throw InputError(fmt::format("{}:1: expected the columns {}", path.string(), kHeader));
    std::vector<EffectsCell> cells;
    const CsvRecords records = splitCsv(text, path.string());
    for (std::size_t i = 1; i < records.complete.size(); ++i) {
        const auto& [line, f] = records.complete[i];
        EffectsCell c;
        if (f.size() != kColumns || !parse(f[1], c.frame) || !parse(f[6], c.frameMs) ||
            !parse(f[7], c.frameMsLow) || !parse(f[8], c.frameMsHigh) ||
            !parse(f[9], c.rmseToAuto) || !parse(f[10], c.maxToAuto) || !parse(f[11], c.rmse))
            throw InputError(fmt::format("{}:{}: no plan of a frame", path.string(), line));
        c.scene = f[0], c.method = f[2], c.setting = f[3], c.plan = f[4], c.status = f[5];
        cells.push_back(std::move(c));
    }
    return cells;
}

std::string effectsTableMarkdown(const std::vector<EffectsCell>& cells) {
    const std::vector<Group> groups = grouped(cells);
    std::vector<std::string> settings;
    std::map<std::string, Totals> totals;
    std::map<std::pair<std::string, std::string>, LeftOut> leftOut;  // by setting and plan
    Totals whole;
    std::string scenes;
    std::vector<Cells> lines;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const EffectsCell& any = *groups[g].front();
        const EffectsCell *automatic = withPlan(groups[g], kAuto), *all = withPlan(groups[g], kAll);
        if (automatic && all) {
            if (!totals.contains(any.setting)) settings.push_back(any.setting);
            totals[any.setting].add(*all, *automatic);
            whole.add(*all, *automatic);
        }
        for (const EffectsCell* c : groups[g])
            if (automatic && c->plan.starts_with('-'))
                leftOut[{any.setting, c->plan}].add(*automatic, *c);
        for (const EffectsCell* c : groups[g]) {
            const Number relative = automatic && automatic->frameMs && c->frameMs
                                        ? ratio(*c->frameMs, *automatic->frameMs)
                                        : std::nullopt;
            lines.push_back({fmt::format("{}", c->frame), escaped(c->setting), planInWords(c->plan),
                             c->status, number(c->frameMs), number(relative), number(c->rmseToAuto),
                             number(c->maxToAuto), number(c->rmse)});
        }
        if (g + 1 < groups.size() && groups[g + 1].front()->scene == any.scene) continue;
        scenes += fmt::format("## {}\n\n", escaped(any.scene)) +
                  table({"frame", "setting", "plan", "status", "frame ms", "time / auto",
                         "rmse to auto", "max to auto", "rmse"},
                        4, lines);
        lines.clear();
    }
    std::vector<Cells> overall;
    for (const std::string& setting : settings)
        overall.push_back(totals[setting].line(escaped(setting)));
    overall.push_back(whole.line("all of them"));
    std::vector<Cells> effects;
    for (const std::string& setting : settings)
        for (const EffectInfo& info : allEffects())
            if (const auto at = leftOut.find({setting, "-" + std::string(info.id)});
                at != leftOut.end())
                effects.push_back(at->second.line(escaped(setting), std::string(info.id)));
    return "# What effects cost\n\n"
           "Every plan is timed in the same rounds; times in ms are medians. *all* simulates all "
           "that the method can at every pixel, *auto* what the frame calls for. Differences are "
           "over scored pixels: to the image of auto, and of V to the reference.\n\n" +
           table({"setting", "frames", "all ms", "auto ms", "auto / all", "max difference"}, 1,
                 overall) +
           "Each effect left out of auto, over the frames that call for it: what that saves and "
           "what it does to the image.\n\n" +
           table({"setting", "left out", "frames", "time / auto", "rmse to auto", "max to auto"}, 2,
                 effects) +
           scenes;
}

}  // namespace penumbra
