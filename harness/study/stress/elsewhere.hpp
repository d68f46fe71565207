#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace penumbra::stress {

/// A hard case of METHODS.md that is not a case of the matrix.
struct Elsewhere {
    int number = 0;  ///< there, from 1 to kNumbers
    std::string what;
    std::string because;             ///< why it is none
    std::vector<std::string> tests;  ///< "Suite.Name", in tests/; empty where nothing is to hold
};

/// How many hard cases METHODS.md has.
constexpr int kNumbers = 58;

/// Reads elsewhere.toml; an absent file has no entries. Throws InputError "file:line: what" for
/// malformed entries and a number that is listed twice.
std::vector<Elsewhere> readElsewhere(const std::filesystem::path& file);

}  // namespace penumbra::stress
