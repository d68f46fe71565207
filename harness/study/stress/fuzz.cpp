#include "harness/study/stress/fuzz.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "harness/study/stress/shrink.hpp"

namespace penumbra::stress {
namespace {

bool failsLike(const Draw& draw, const DrawFailure& failure, const TruthBounds& bounds) {
    try {
        const DrawResult result = checkDraw(draw, bounds);
        return result.failure && result.failure->check == failure.check;
    } catch (const InputError&) {
        return false;  // simplified to no scene at all
    }
}

std::string commandFor(const Draw& draw, const std::string& script) {
    std::string command = fmt::format("penumbra compare --scene {} --method {} --size {}x{}",
                                      script, draw.method, draw.size, draw.size);
    for (const auto& [parameter, value] : draw.assignments)
        command += fmt::format(" --set {}.{}={}", draw.method, parameter, value);
    return command;
}

FuzzFailure reproduce(const Draw& found, std::uint32_t index, const DrawFailure& failure,
                      const FuzzOptions& options, const TruthBounds& bounds) {
    FuzzFailure result{index, found, failure, {}};
    result.draw = shrink(found, [&](const Draw& d) { return failsLike(d, failure, bounds); });
    if (const DrawResult shrunk = checkDraw(result.draw, bounds); shrunk.failure)
        result.failure = *shrunk.failure;
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) throw InputError(fmt::format("--out {}: {}", options.out.string(), error.message()));
    const std::string name = fmt::format("draw-{}-{}", options.seed, index);
    result.script = options.out / (name + ".toml");
    result.draw.scene.write(
        options.out / name,
        {fmt::format("{}: {:.4g}, bound {:.4g}; {}", result.failure.check, result.failure.deviation,
                     result.failure.bound, result.failure.note),
         commandFor(result.draw, name + ".toml")});
    return result;
}

}  // namespace

FuzzResult fuzz(const FuzzOptions& options, const TruthBounds& bounds,
                const std::function<void(std::uint32_t)>& starts) {
    std::vector<std::string> methods = options.methods;
    for (const std::string& id : methods) findMethod(id);
    if (methods.empty())
        for (const MethodInfo& info : methodRegistry()) methods.push_back(info.id);
    FuzzResult result;
    for (std::uint32_t i = 0; i < options.draws; ++i) {
        starts(i);
        const Draw draw = drawRandom(options.seed, i, methods);
        try {
            draw.scene.build();
        } catch (const InputError&) {
            ++result.invalid;
            continue;
        }
        const DrawResult checked = checkDraw(draw, bounds);
        ++(checked.refused ? result.refused : result.checked);
        if (checked.failure)
            result.failures.push_back(reproduce(draw, i, *checked.failure, options, bounds));
    }
    return result;
}

std::string fuzzText(const FuzzOptions& options, const FuzzResult& result) {
    std::string text;
    for (const FuzzFailure& f : result.failures)
        text += fmt::format("draw {} of seed {}: {} {}: {:.4g}, bound {:.4g}; {}; {}\n", f.index,
                            options.seed, f.draw.method, f.failure.check, f.failure.deviation,
                            f.failure.bound, f.failure.note, f.script.string());
    return text + fmt::format(
                      "{} draws of seed {}: {} checked, {} failed, {} refused by the method, {} no "
                      "scene\n",
                      options.draws, options.seed, result.checked, result.failures.size(),
                      result.refused, result.invalid);
}

}  // namespace penumbra::stress
