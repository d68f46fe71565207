// penumbra_assets OUTDIR: writes every procedural asset as OUTDIR/<name>.glb, the same bytes every
// time.
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "scenes/assets/asset.hpp"

int main(int argc, char** argv) {
    using namespace penumbra::assets;
    if (argc != 2) {
        fmt::print(stderr, "usage: penumbra_assets OUTDIR\n");
        return 2;
    }
    try {
        const std::filesystem::path folder = argv[1];
        std::filesystem::create_directories(folder);
        std::ranges::sort(generators(), {}, &Generator::name);
        for (const Generator& generator : generators()) {
            try {
                Asset asset;
                generator.fill(asset);
                asset.write(folder / (generator.name + ".glb"));
            } catch (const SourceAbsent& absent) {
                fmt::print("{}: left out, {}\n", generator.name, absent.what());
            }
        }
    } catch (const std::exception& error) {
        fmt::print(stderr, "penumbra_assets: {}\n", error.what());
        return 2;
    }
    return 0;
}
