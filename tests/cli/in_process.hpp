#pragma once

#include <gtest/gtest.h>

#include "harness/cli/cli.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra::test {

/// `penumbra ARGUMENTS...` without a process of its own, whose start (hundreds of libraries) takes
/// many times what refusing a value does. For variants of what other tests run for real.
inline Finished penumbraInProcess(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "penumbra");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    Finished done;
    done.exitCode = runCommandLine(static_cast<int>(arguments.size()), argv.data());
    done.out = ::testing::internal::GetCapturedStdout();
    done.err = ::testing::internal::GetCapturedStderr();
    return done;
}

}  // namespace penumbra::test
