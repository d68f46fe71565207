#include <fmt/format.h>

#include "core/error.hpp"
#include "core/gl/context.hpp"
#include "harness/cli/commands.hpp"
#include "harness/report/report.hpp"
#include "harness/run/progress.hpp"
#include "harness/study/stress/fuzz.hpp"
#include "harness/study/stress/output.hpp"

namespace penumbra {
namespace {

struct Entered {
    stress::MatrixOptions matrix;
    std::string context = "osmesa";
    std::filesystem::path out;
    bool markdown = false;
    std::uint32_t draws = 0;
};

int runStressDraws(const Entered& entered) {
    const auto context = gl::Context::create(gl::parseContextKind(entered.context));
    const stress::TruthBounds bounds =
        stress::TruthBounds::read(stress::CaseLibrary::standard().folder / "random.toml");
    const stress::FuzzOptions options{entered.matrix.seed, entered.draws, entered.matrix.methods,
                                      entered.out.empty() ? "results/stress" : entered.out};
    ProgressLine line(options.draws);
    const stress::FuzzResult result = stress::fuzz(options, bounds, [&](std::uint32_t i) {
        if (i % 50 == 0) line.step(i, fmt::format("random draw {}", i));
    });
    fmt::print("{}", fuzzText(options, result));
    return result.failures.empty() ? 0 : 1;
}

int runStressMatrix(const Entered& entered) {
    const auto context = gl::Context::create(gl::parseContextKind(entered.context));
    std::optional<ProgressLine> line;
    const stress::Matrix matrix =
        stress::runMatrix(stress::CaseLibrary::standard(), entered.matrix,
                          [&](std::size_t done, std::size_t all, const std::string& what) {
                              if (!line) line.emplace(all);
                              line->step(done, what);
                          });
    line.reset();
    if (!entered.out.empty()) {
        stress::writeMatrix(matrix, entered.out);
        const RunFolder run(entered.out);
        if (std::filesystem::exists(run.summary())) writeArtefacts(run);
    }
    fmt::print("{}", entered.markdown ? markdownText(matrix) : tableText(matrix));
    return matrix.wrong() ? 1 : 0;
}

}  // namespace

void addStressCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "stress",
        "The hard cases on every method: what must hold, and by how much it does not. Exit code 1 "
        "if a cell fails that scenes/stress/known.toml does not explain, or passes although it is "
        "listed there");
    auto entered = std::make_shared<Entered>();
    command->add_option("--method", entered->matrix.methods, "method ids (default: all)");
    command->add_option("--case", entered->matrix.cases, "ids of hard cases (default: all)");
    command->add_option("--seed", entered->matrix.seed, "of the frames' noise and of the draws");
    auto* random = command->add_option(
        "--random", entered->draws,
        "instead of the cases, so many random scenes, methods and settings; failures are shrunk "
        "and written to --out (default: results/stress) as scene scripts");
    random->check(CLI::Range(1u, 10'000'000u))->excludes("--case");
    command->add_option("--context", entered->context, "osmesa | egl | glfw | auto");
    command->add_option(
        "--out", entered->out,
        "folder for stress.csv, junit.xml and stress.md; in a run folder, also a section of "
        "its summary.md");
    command->add_flag("--markdown", entered->markdown, "print docs/STABILITY.md")->excludes(random);
    command->callback([entered, &action] {
        action = [entered] {
            return entered->draws > 0 ? runStressDraws(*entered) : runStressMatrix(*entered);
        };
    });
}

}  // namespace penumbra
