#include <csignal>

#include "harness/cli/cli.hpp"

int main(int argc, char** argv) {
    // Then a write beyond the limit on the size of files fails as on a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    return penumbra::runCommandLine(argc, argv);
}
