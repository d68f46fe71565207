#include "core/scene/memory_budget.hpp"

#include <fmt/format.h>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {

void MemoryBudget::charge(std::uint64_t count, std::uint64_t bytesEach, const std::string& pointer,
                          const char* what) {
    const std::uint64_t leftBytes = limitBytes_ - usedBytes_;
    if (bytesEach > 0 && count > leftBytes / bytesEach) {
        constexpr double kMiB = 1 << 20;
        failInput(
            file_, pointer,
            fmt::format("{} would need {:.4g} MiB after {:.4g} MiB for the rest; --max-memory "
                        "is {:.4g} MiB",
                        what, static_cast<double>(count) * static_cast<double>(bytesEach) / kMiB,
                        static_cast<double>(usedBytes_) / kMiB,
                        static_cast<double>(limitBytes_) / kMiB));
    }
    usedBytes_ += count * bytesEach;
}

}  // namespace penumbra::scene_detail
