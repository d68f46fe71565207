#include <fmt/format.h>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/run/compare.hpp"
#include "harness/study/scaling.hpp"

namespace penumbra {
namespace {

/// As entered, before it is parsed and checked.
struct Entered {
    CompareOptions options;
    std::optional<std::string> size;
    std::optional<int> repeats;
    std::string shard = "1/1", effects = "auto", context = "osmesa";
    std::string scaling;
};

int run(Entered entered) {
    CompareOptions& o = entered.options;
    finishTruthOptions(o, entered.size);
    std::tie(o.shard, o.shards) = parsePair("--shard", entered.shard, '/');
    if (o.shard > o.shards)
        throw InputError(fmt::format("--shard {}: expected I/N with 1 <= I <= N", entered.shard));
    o.effects = EffectChoice::parse(entered.effects);
    o.context = gl::parseContextKind(entered.context);
    o.repeats = entered.repeats.value_or(o.paired.empty() ? 5 : 25);
    return entered.scaling.empty() ? compare(o) : scaling(o, parseScalingAxis(entered.scaling));
}

}  // namespace

void addCompareCommand(CLI::App& app, Action& action, const std::string& commandLine) {
    auto* command = app.add_subcommand("compare", "Render, score and time methods over scenes");
    auto entered = std::make_shared<Entered>();
    CompareOptions& o = entered->options;
    o.command = commandLine;
    command->add_option("--suite", o.suite, "suite of scenes (default: standard, unless --scene)");
    command->add_option("--scene", o.scenes, "scene id, script (.toml) or asset (.glb, .gltf)");
    command->add_option(
        "--method", o.settings.methods,
        "method ids; separation: the error of V x irradiance itself (default: all)");
    command->add_option("--set", o.settings.sets, "METHOD.PARAMETER=VALUE");
    command->add_option("--sweep", o.settings.sweeps, "METHOD.PARAMETER=VALUE,VALUE,...");
    command->add_flag("--ladder", o.settings.ladder, "every method's quality ladder");
    command
        ->add_option("--paired", o.paired,
                     "A B: time two settings in pairs and say which is faster; each is METHOD or "
                     "'METHOD:PARAMETER=VALUE;PARAMETER=VALUE...', as the CSV's method and params")
        ->expected(2);
    command->add_option("--effects", entered->effects,
                        "auto | all | none | a,b,... (see list effects)");
    auto* table = command->add_flag(
        "--effects-table", o.effectsTable,
        "also time every setting under all effects and with each one left out, and "
        "print what that costs");
    addTruthOptions(*command, o, entered->size, "image size WxH (default: 512x512)");
    addLoadOptions(*command, o.load);
    command
        ->add_option("--repeats", entered->repeats,
                     "rounds in which every cell is timed (default: 5; one that was timed three "
                     "times and took 2 s in that leaves the further ones), or pairs (default: 25)")
        ->check(CLI::Range(1, 10000));
    command->add_option("--curve-metric", o.curveMetric,
                        "error on curves and in cost tables (default: rmse; see list metrics)");
    command->add_option("--context", entered->context, "osmesa | egl | glfw | auto");
    command->add_option("--out", o.out, "run folder (default: results/<time>)");
    command->add_flag("--resume", o.resume, "do what is missing in --out");
    auto* shard = command->add_option("--shard", entered->shard,
                                      "I/N: only the I-th of N parts of the cells");
    command
        ->add_option("--scaling", entered->scaling,
                     "triangles | pixels | map_size | light_size | slices: only time the methods "
                     "over a series of it and fit the exponent")
        ->excludes(shard)
        ->excludes(table);
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
