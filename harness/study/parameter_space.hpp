#pragma once

#include <cstdint>
#include <vector>

#include "harness/run/settings.hpp"

namespace penumbra {

/// `id` with `assignments` over its defaults, named and spelled as everywhere. Throws InputError.
Setting settingOf(const std::string& id, const Assignments& assignments);

/// The method's ladder, cheapest first, and its defaults last, without repetition.
std::vector<Setting> seedSettings(const std::string& method);

/// A setting near `from`, one or two of its parameters changed: a number by a factor of 1.41 or 2
/// up or down, a choice to another. Numbers stay within twice what the method's ladder and defaults
/// span (a factor of four around the default where the ladder leaves it alone) and in their
/// declared range. A pure function of its arguments; may return `from` itself where nothing can be
/// changed.
Setting neighbour(const Setting& from, std::uint32_t seed);

}  // namespace penumbra
