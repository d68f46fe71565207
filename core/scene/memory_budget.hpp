#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/scene/load_options.hpp"

namespace penumbra::scene_detail {

/// What one asset may still make the loader allocate. Everything whose size the asset decides is
/// charged here before it is allocated, and nothing is given back: what is bounded is the sum of
/// all that was ever asked for, and with it the work that a small file can cause by referring to
/// one large accessor many times.
class MemoryBudget {
  public:
    explicit MemoryBudget(std::filesystem::path file = {},
                          std::uint64_t limitBytes = kDefaultMaxMemoryBytes)
        : file_(std::move(file)), limitBytes_(limitBytes) {}

    /// Throws InputError naming `pointer` where `count` times `bytesEach` is more than is left;
    /// `what` completes "... would need".
    void charge(std::uint64_t count, std::uint64_t bytesEach, const std::string& pointer,
                const char* what);

  private:
    std::filesystem::path file_;
    std::uint64_t limitBytes_, usedBytes_ = 0;
};

}  // namespace penumbra::scene_detail
