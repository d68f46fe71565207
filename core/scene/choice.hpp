#pragma once

#include <optional>
#include <string>
#include <vector>

namespace penumbra::scene_detail {

/// Which of `names` a user means by `wanted`: an index, else a name that only one of them has.
std::optional<std::size_t> chosenByIndexOrName(const std::string& wanted,
                                               const std::vector<std::string>& names);

/// "0 'hall', 1, 2 'garden'", cut after a dozen.
std::string indexedNames(const std::vector<std::string>& names);

}  // namespace penumbra::scene_detail
