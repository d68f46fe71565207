#include "harness/study/parameter_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/sampling/sampling.hpp"

namespace penumbra {
namespace {

/// Where the search may take a number.
struct Span {
    double low = 0.0, high = 0.0;
};

/// Declared range and what the ladder and the defaults span, of a method's numeric parameter.
Span spanOf(const std::string& method, std::size_t index) {
    std::vector<double> used;
    for (const Setting& seed : seedSettings(method))
        used.push_back(seed.make()->parameters()[index]->number());
    const auto [least, most] = std::ranges::minmax(used);
    const double factor = least == most ? 4.0 : 2.0;

    const auto instance = findMethod(method).make();
    Parameter& parameter = *instance->parameters()[index];
    const std::vector<std::string> ends = parameter.extremes();
    parameter.setText(ends.front());
    const double low = parameter.number();
    parameter.setText(ends.back());
    const double high = parameter.number();
    // What is 0 by default has no scale but its range's.
    const double top = most > 0.0 ? most * factor : std::min(1.0, high);
    return {std::clamp(least / factor, low, high), std::clamp(top, low, high)};
}

/// Another value of the number, canonical to three digits; the same one where there is none.
std::string moved(const Parameter& parameter, const Span& span, std::uint32_t random) {
    constexpr std::array kFactors = {0.5, 0.70711, 1.41421, 2.0};
    const double now = parameter.number();
    double next = now * kFactors[random % kFactors.size()];
    if (now == 0.0) next = span.high * toUnitFloat(hash(random));
    next = std::clamp(next, span.low, span.high);
    if (parameter.isFloat()) return fmt::format("{:.3g}", next);
    return fmt::format("{:.0f}", std::round(next));
}

}  // namespace

Setting settingOf(const std::string& id, const Assignments& assignments) {
    std::string text = id;
    for (const auto& [parameter, value] : assignments)
        text += (text.size() == id.size() ? ':' : ';') + parameter + '=' + value;
    return parseSetting("tune", text);
}

std::vector<Setting> seedSettings(const std::string& method) {
    std::vector<Assignments> all = findMethod(method).make()->ladder();
    all.emplace_back();
    std::vector<Setting> seeds;
    for (const Assignments& assignments : all) {
        Setting setting = settingOf(method, assignments);
        if (std::ranges::find(seeds, setting.name, &Setting::name) == seeds.end())
            seeds.push_back(std::move(setting));
    }
    return seeds;
}

Setting neighbour(const Setting& from, std::uint32_t seed) {
    const auto instance = from.make();
    const std::vector<Parameter*>& parameters = instance->parameters();
    if (parameters.empty()) return from;
    const std::uint32_t changes = 1 + hash(seed, 0u) % 2;
    for (std::uint32_t change = 1; change <= changes; ++change) {
        const std::uint32_t random = hash(seed, change, 1u);
        const std::size_t index = hash(seed, change, 0u) % parameters.size();
        Parameter& parameter = *parameters[index];
        const bool number = parameter.type() == "int" || parameter.type() == "float";
        const std::vector<std::string> choices = parameter.extremes();
        parameter.setText(number ? moved(parameter, spanOf(from.method, index), random)
                                 : choices[random % choices.size()]);
    }
    Assignments assignments;
    for (const Parameter* p : parameters)
        if (p->text() != p->defaultText()) assignments.emplace_back(p->id(), p->text());
    return settingOf(from.method, assignments);
}

}  // namespace penumbra
