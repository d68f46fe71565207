#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/exchange/score.hpp"
#include "harness/run/progress.hpp"

namespace penumbra {
namespace {

struct Entered {
    ScoreOptions options;
    std::optional<std::string> size;
    bool json = false, linear = false, srgb = false;
};

int run(Entered entered) {
    ScoreOptions& o = entered.options;
    finishTruthOptions(o.truth, entered.size);
    o.sizeGiven = entered.size.has_value();
    o.transfer = entered.linear ? Transfer::linear
                 : entered.srgb ? Transfer::srgb
                                : Transfer::byFile;
    if (o.image.empty() == o.shadowed.empty())
        throw InputError("score: needed is --image, or --shadowed and --unshadowed");
    if (o.frameMs && !(*o.frameMs > 0.0 && std::isfinite(*o.frameMs)))
        throw InputError(fmt::format("--frame-ms {}: expected milliseconds above 0", *o.frameMs));
    Row row;
    {
        ProgressLine progress(1);
        row = scoreImage(
            o, [&](const std::string& text) { progress.note(text); }, referenceProgress(progress));
    }
    if (entered.json)
        fmt::print("{}\n", toJson(row));
    else
        fmt::print("{}\n{}\n", csvHeader(), toCsv(row));
    return 0;
}

}  // namespace

void addScoreCommand(CLI::App& app, Action& action, const std::string& commandLine) {
    auto* command = app.add_subcommand(
        "score", "Score another renderer's visibility image like a method's (docs/SCORING.md)");
    auto entered = std::make_shared<Entered>();
    ScoreOptions& o = entered->options;
    o.command = commandLine;
    command->add_option("--scene", o.scene, "scene id, script (.toml) or asset (.glb, .gltf)")
        ->required();
    command->add_option("--frame", o.frame, "which frame (default: 0)");
    auto* image = command->add_option("--image", o.image, "visibility, 1 lit");
    auto* shadowed =
        command->add_option("--shadowed", o.shadowed,
                            "a picture with shadows; visibility is its ratio to --unshadowed");
    auto* unshadowed =
        command->add_option("--unshadowed", o.unshadowed, "the same picture without shadows");
    shadowed->needs(unshadowed)->excludes(image);
    unshadowed->needs(shadowed)->excludes(image);
    auto* linear = command->add_flag("--linear", entered->linear,
                                     "the files hold linear values (default: float files)");
    command
        ->add_flag("--srgb", entered->srgb,
                   "the files hold sRGB-encoded values (default: integer files)")
        ->excludes(linear);
    command->add_option("--name", o.name, "of the row (default: the file's stem)");
    command->add_option("--frame-ms", o.frameMs, "what the frame cost, in milliseconds");
    command->add_flag("--json", entered->json, "as JSON, keys as the columns of results.csv");
    command->add_option("--out", o.run, "run folder, new or existing, to add the row to");
    addTruthOptions(*command, o.truth, entered->size,
                    "the frame's size WxH (default: the image's own)");
    addLoadOptions(*command, o.truth.load);
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
