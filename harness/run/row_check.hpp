#pragma once

#include <filesystem>
#include <vector>

#include "harness/run/row.hpp"

namespace penumbra {

/// readCsv() for a folder that others may have put together: also two rows of one cell, numbers
/// that are not finite or below 0 where they cannot be, and scenes and settings that are no names
/// of files throw InputError with file:line. A status may be any text, and a last line cut short is
/// dropped.
std::vector<Row> readCheckedCsv(const std::filesystem::path& path);

}  // namespace penumbra
