#include "harness/run/files.hpp"

#include <cstdlib>
#include <fstream>

namespace penumbra {

void appendToStepSummary(const std::string& markdown) {
    if (const char* step = std::getenv("GITHUB_STEP_SUMMARY"); step && *step)
        std::ofstream(step, std::ios::app) << markdown;
}

}  // namespace penumbra
