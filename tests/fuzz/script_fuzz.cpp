#include <cstdlib>

#include "core/error.hpp"
#include "core/scene/scene.hpp"
#include "tests/fuzz/work_folder.hpp"

/// Any bytes as a scene script, over the assets of $PENUMBRA_ASSETS (fuzz_corpus writes them): its
/// first and last frames are evaluated, or it is an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    LoadOptions options;
    options.maxMemoryBytes = std::uint64_t{256} << 20;
    try {
        const std::string file = testing::writeInput("script.toml", data, size);
        const auto scene =
            loadScene(file, {testing::workFolder(), SceneLibrary::standard().assets}, options);
        scene->frame(0);
        scene->frame(scene->frameCount() - 1);
    } catch (const InputError&) {
    } catch (const AssetAbsent&) {
    }
    return 0;
}
