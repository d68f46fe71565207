#pragma once

#include <filesystem>
#include <vector>

namespace penumbra {

/// Joins shards of one run into the new folder `out`: rows, images, records. Throws InputError if
/// `out` holds a run, if the runs differ in size, seed, reference or effects, or if two have a row
/// of the same cell. Returns 3 if any row failed, else 0.
int mergeRuns(const std::filesystem::path& out, const std::vector<std::filesystem::path>& runs);

}  // namespace penumbra
