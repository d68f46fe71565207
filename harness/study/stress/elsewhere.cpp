#include "harness/study/stress/elsewhere.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "harness/study/stress/toml_table.hpp"

namespace penumbra::stress {

std::vector<Elsewhere> readElsewhere(const std::filesystem::path& file) {
    std::vector<Elsewhere> list;
    if (!std::filesystem::exists(file)) return list;
    TomlTable root = TomlTable::read(file);
    for (TomlTable& table : root.tables("elsewhere")) {
        Elsewhere entry;
        entry.number = static_cast<int>(table.number("number", 1, kNumbers));
        entry.what = table.text("what");
        entry.because = table.text("because");
        if (table.has("tests")) entry.tests = table.texts("tests");
        table.finish();
        if (std::ranges::find(list, entry.number, &Elsewhere::number) != list.end())
            table.fail("number", fmt::format("{} is listed already", entry.number));
        list.push_back(std::move(entry));
    }
    root.finish();
    return list;
}

}  // namespace penumbra::stress
