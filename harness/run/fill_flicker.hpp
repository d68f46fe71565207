#pragma once

#include "harness/run/run_folder.hpp"

namespace penumbra {

/// Fills the flicker column of results.csv from the folder's images, where both a frame and the one
/// before it are there. Works on the folder, not in memory, because the frame before may have been
/// rendered before an interruption or by another shard. Rows that have a flicker keep it.
void fillFlicker(const RunFolder& folder);

}  // namespace penumbra
