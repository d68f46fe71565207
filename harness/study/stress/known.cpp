#include "harness/study/stress/known.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "harness/study/stress/toml_table.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra::stress {

std::vector<KnownLimitation> readKnown(const std::filesystem::path& file,
                                       const std::vector<std::string>& cases) {
    std::vector<KnownLimitation> list;
    if (!std::filesystem::exists(file)) return list;
    TomlTable root = TomlTable::read(file);
    for (TomlTable& table : root.tables("known")) {
        KnownLimitation known;
        known.hardCase = table.text("case");
        if (std::ranges::find(cases, known.hardCase) == cases.end())
            table.fail("case", fmt::format("unknown case '{}'; the cases are {}", known.hardCase,
                                           scene_detail::listed(cases)));
        known.method = table.text("method");
        try {
            findMethod(known.method);
        } catch (const InputError& e) {
            table.fail("method", e.what());
        }
        known.predicted = table.number("predicted", 0.0, 1e6);
        known.tolerance = table.number("tolerance", 0.0, 1e6);
        known.because = table.text("because");
        known.place = table.place("case");
        table.finish();
        if (findKnown(list, known.hardCase, known.method))
            table.fail("case",
                       fmt::format("{} with {} is listed already", known.hardCase, known.method));
        list.push_back(std::move(known));
    }
    root.finish();
    return list;
}

const KnownLimitation* findKnown(const std::vector<KnownLimitation>& known,
                                 const std::string& hardCase, const std::string& method) {
    for (const KnownLimitation& entry : known)
        if (entry.hardCase == hardCase && entry.method == method) return &entry;
    return nullptr;
}

}  // namespace penumbra::stress
