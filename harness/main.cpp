#include "harness/cli/cli.hpp"

int main(int argc, char** argv) { return penumbra::runCommandLine(argc, argv); }
