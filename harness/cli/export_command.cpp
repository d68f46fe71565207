#include <fmt/format.h>

#include "harness/cli/commands.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/exchange/export.hpp"
#include "harness/run/progress.hpp"

namespace penumbra {
namespace {

struct Entered {
    ExportOptions options;
    std::optional<std::string> size;
};

int run(Entered entered) {
    ExportOptions& o = entered.options;
    finishTruthOptions(o.truth, entered.size);
    std::vector<std::filesystem::path> files;
    {
        ProgressLine progress(1);
        files = exportFrame(
            o, [&](const std::string& text) { progress.note(text); }, referenceProgress(progress));
    }
    for (const auto& file : files) fmt::print("{}\n", file.string());
    return 0;
}

}  // namespace

void addExportCommand(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("export", "Write one frame for other renderers: .glb, .json, EXR");
    auto entered = std::make_shared<Entered>();
    ExportOptions& o = entered->options;
    command->add_option("--scene", o.scene, "scene id, script (.toml) or asset (.glb, .gltf)")
        ->required();
    command->add_option("--frame", o.frame, "which frame (default: 0)");
    command->add_option("--out", o.out, "folder to write into")->required();
    addTruthOptions(*command, o.truth, entered->size, "image size WxH (default: 512x512)");
    addLoadOptions(*command, o.truth.load);
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
