#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/scene/supported_input.hpp"

namespace penumbra {
namespace {

/// docs/INPUT.md holds the table as it is: `penumbra list inputs --markdown` makes its rows anew.
TEST(InputDocument, HasEveryRowOfTheTable) {
    std::ifstream file(PENUMBRA_TEST_DIR "/../docs/INPUT.md");
    ASSERT_TRUE(file);
    std::stringstream text;
    text << file.rdbuf();
    for (const SupportedInput& input : supportedInputs()) {
        const std::string row = "| " + std::string(input.id) + " | " +
                                std::string(input.kindName()) + " | " + input.doc + " |\n";
        EXPECT_NE(text.str().find(row), std::string::npos) << row;
    }
}

}  // namespace
}  // namespace penumbra
