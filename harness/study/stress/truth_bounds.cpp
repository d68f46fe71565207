#include "harness/study/stress/truth_bounds.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "harness/study/stress/toml_table.hpp"

namespace penumbra::stress {
namespace {

TruthBound readSampled(TomlTable& table, const std::string& method) {
    TruthBound bound;
    bound.samples = table.text("samples");
    bound.rmsFactor = table.number("rms_factor", 0.0, 100.0);
    const auto instance = findMethod(method).make();
    std::vector<std::string> ids;
    for (const Parameter* parameter : instance->parameters()) ids.push_back(parameter->id());
    if (std::ranges::find(ids, bound.samples) == ids.end())
        table.fail("samples", fmt::format("{} has no parameter '{}'; it has {}", method,
                                          bound.samples, scene_detail::listed(ids)));
    return bound;
}

}  // namespace

const TruthBound& TruthBounds::of(const std::string& method) const {
    const auto at = own.find(method);
    return at == own.end() ? general : at->second;
}

TruthBounds TruthBounds::read(const std::filesystem::path& file) {
    TruthBounds bounds;
    TomlTable root = TomlTable::read(file);
    TomlTable general = root.table("general");
    bounds.general.meanBeyondHard = general.number("mean_beyond_hard", 0.0, 1.0);
    bounds.general.because = general.text("because");
    general.finish();
    for (TomlTable& table : root.tables("bound")) {
        const std::string method = table.text("method");
        try {
            findMethod(method);
        } catch (const InputError& e) {
            table.fail("method", e.what());
        }
        TruthBound bound;
        if (table.has("samples"))
            bound = readSampled(table, method);
        else
            bound.meanBeyondHard = table.number("mean_beyond_hard", 0.0, 1.0);
        bound.because = table.text("because");
        table.finish();
        bounds.own[method] = bound;
    }
    root.finish();
    return bounds;
}

}  // namespace penumbra::stress
