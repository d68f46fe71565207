#include <fmt/format.h>

#include <cstdio>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/metrics/diff.hpp"

namespace penumbra {
namespace {

struct Entered {
    std::filesystem::path reference, image, out;
    bool json = false, linear = false, srgb = false;
};

int run(const Entered& entered) {
    const Transfer transfer = entered.linear ? Transfer::linear
                              : entered.srgb ? Transfer::srgb
                                             : Transfer::byFile;
    const DiffImage reference = readForDiff(entered.reference, transfer);
    const DiffImage image = readForDiff(entered.image, transfer);
    const Diff result = diff(reference, image);
    for (const DiffImage* read : {&reference, &image}) {
        if (!read->note.empty()) fmt::print(stderr, "{}\n", read->note);
    }
    if (!entered.out.empty()) {
        try {
            writePng(entered.out, errorPicture(result, image.image.width, image.image.height));
        } catch (const std::exception& e) {
            throw InputError(fmt::format("--out {}", e.what()));
        }
    }
    fmt::print("{}", entered.json ? diffJson(result) : diffText(result));
    return 0;
}

}  // namespace

void addDiffCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("diff", "Compare any two images of one size: every metric");
    auto entered = std::make_shared<Entered>();
    command->add_option("reference", entered->reference, "the image that is right")->required();
    command->add_option("image", entered->image, "the image to judge")->required();
    command->add_flag("--json", entered->json, "as JSON, keys as the columns of results.csv");
    auto* linear = command->add_flag("--linear", entered->linear,
                                     "both files hold linear values (default: float files)");
    command
        ->add_flag("--srgb", entered->srgb,
                   "both files hold sRGB-encoded values (default: integer files)")
        ->excludes(linear);
    command->add_option("--out", entered->out,
                        "write an error map (PNG): red too bright, blue too dark, full at 0.25");
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
