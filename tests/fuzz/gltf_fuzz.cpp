#include "core/error.hpp"
#include "core/scene/scene.hpp"
#include "tests/fuzz/work_folder.hpp"

/// Any bytes as a glTF file: its scene is loaded and its frame evaluated, or it is an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    LoadOptions options;
    options.maxMemoryBytes = std::uint64_t{256} << 20;
    try {
        const std::string file = testing::writeInput("asset.glb", data, size);
        loadScene(file, {testing::workFolder(), testing::workFolder()}, options)->frame(0);
    } catch (const InputError&) {
    }
    return 0;
}
