#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/study/tune.hpp"

namespace penumbra {
namespace {

struct Entered {
    TuneOptions options;
    std::optional<std::string> size;
    std::string context = "osmesa";
};

int run(Entered entered) {
    TuneOptions& o = entered.options;
    finishTruthOptions(o, entered.size);
    if (o.maxRmse.has_value() == o.maxMs.has_value())
        throw InputError("tune: needed is either --max-rmse or --max-ms");
    if (o.maxRmse && !(*o.maxRmse > 0.0 && *o.maxRmse <= 1.0))
        throw InputError(
            fmt::format("--max-rmse {}: expected a number above 0, at most 1", *o.maxRmse));
    if (o.maxMs && !(*o.maxMs > 0.0 && std::isfinite(*o.maxMs)))
        throw InputError(fmt::format("--max-ms {}: expected milliseconds above 0", *o.maxMs));
    o.context = gl::parseContextKind(entered.context);
    return tune(o);
}

}  // namespace

void addTuneCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "tune",
        "Find the best setting of a method, or of all, under a limit of error or time. Candidates "
        "and scores are a function of --seed; times are measured, and kept in the --cache folder: "
        "with the same seed, cache, machine and program the answer is the same. With another cache "
        "folder or --remeasure the clock's noise may choose among settings that are nearly as "
        "good");
    auto entered = std::make_shared<Entered>();
    TuneOptions& o = entered->options;
    command->add_option("--scene", o.scene, "scene id, script (.toml) or asset (.glb, .gltf)")
        ->required();
    command->add_option("--frame", o.frame, "which frame (default: 0); its maps are always built");
    command->add_option("--method", o.methods, "method ids (default: all)");
    command->add_option("--max-rmse", o.maxRmse, "find the fastest setting with this rmse or less");
    command->add_option("--max-ms", o.maxMs,
                        "find the most accurate setting with this median frame time or less");
    addTruthOptions(*command, o, entered->size, "image size WxH (default: 512x512)");
    addLoadOptions(*command, o.load);
    command->add_option("--context", entered->context, "osmesa | egl | glfw | auto");
    command->add_flag("--remeasure", o.remeasure, "measure anew what the cache folder holds");
    command->add_flag("--against-ladders", o.againstLadders,
                      "then measure the methods' ladders beside what was found");
    command->add_option("--out", o.out, "folder for tune.csv, everything that was measured");
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
