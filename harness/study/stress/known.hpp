#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace penumbra::stress {

/// A failure that is explained: a method's documented limitation, the deviation that follows from
/// it and why.
struct KnownLimitation {
    std::string hardCase, method;
    double predicted = 0.0;  ///< deviation
    double tolerance = 0.0;  ///< how far from it the measured one may lie
    std::string because;
    std::string place;  ///< "file:line"
};

/// Reads known.toml; an absent file has no entries. Throws InputError "file:line: what" for
/// malformed entries, cases that are not among `cases`, methods that are not registered and a pair
/// that is listed twice.
std::vector<KnownLimitation> readKnown(const std::filesystem::path& file,
                                       const std::vector<std::string>& cases);

/// The entry of a pair, or null.
const KnownLimitation* findKnown(const std::vector<KnownLimitation>& known,
                                 const std::string& hardCase, const std::string& method);

}  // namespace penumbra::stress
