#include <fmt/format.h>

#include <charconv>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/run/compare.hpp"

namespace penumbra {
namespace {

/// "AxB" or "A/B": two positive integers around `separator`.
std::pair<int, int> parsePair(const std::string& option, const std::string& text, char separator) {
    int a = 0, b = 0;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, a);
    if (first.ec == std::errc() && first.ptr != end && *first.ptr == separator) {
        const auto second = std::from_chars(first.ptr + 1, end, b);
        if (second.ec == std::errc() && second.ptr == end && a > 0 && b > 0) return {a, b};
    }
    throw InputError(fmt::format("{} {}: expected two positive integers as in {}", option, text,
                                 separator == 'x' ? "512x512" : "1/4"));
}

/// As entered, before it is parsed and checked.
struct Entered {
    CompareOptions options;
    std::string size = "512x512", shard = "1/1", effects = "auto", context = "osmesa";
};

int run(Entered entered) {
    CompareOptions& o = entered.options;
    std::tie(o.width, o.height) = parsePair("--size", entered.size, 'x');
    if (o.width > 16384 || o.height > 16384)
        throw InputError(fmt::format("--size {}: at most 16384x16384", entered.size));
    std::tie(o.shard, o.shards) = parsePair("--shard", entered.shard, '/');
    if (o.shard > o.shards)
        throw InputError(fmt::format("--shard {}: expected I/N with 1 <= I <= N", entered.shard));
    // Said here because CLI::Range lets NaN through.
    if (!(o.referenceSe >= 1e-5 && o.referenceSe <= 0.5))
        throw InputError(
            fmt::format("--reference-se {}: expected a number in 1e-05..0.5", o.referenceSe));
    o.effects = EffectChoice::parse(entered.effects);
    o.context = gl::parseContextKind(entered.context);
    return compare(o);
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
    command->add_option("--effects", entered->effects,
                        "auto | all | none | a,b,... (see list effects)");
    command->add_option("--size", entered->size, "image size WxH");
    command->add_option("--repeats", o.repeats, "timed repeats of every cell")
        ->check(CLI::Range(1, 10000));
    command->add_option("--seed", o.seed, "of everything random");
    command->add_option("--threads", o.threads, "CPU threads (default: all)")
        ->check(CLI::Range(1, 1024));
    command->add_option("--context", entered->context, "osmesa | egl | glfw | auto");
    command
        ->add_option("--reference", o.reference,
                     "embree | exact (polygon clipping; no noise, slow in clutter)")
        ->check(CLI::IsMember({"embree", "exact"}));
    command->add_option("--reference-se", o.referenceSe, "standard error to reach in every pixel");
    command->add_option("--cache", o.cache, "folder of cached references");
    command->add_option("--out", o.out, "run folder (default: results/<time>)");
    command->add_flag("--resume", o.resume, "do what is missing in --out");
    command->add_option("--shard", entered->shard, "I/N: only the I-th of N parts of the cells");
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
