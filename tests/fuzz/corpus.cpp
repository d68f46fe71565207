#include <cstdio>

#include "tests/core/scene_samples.hpp"

namespace {

namespace fs = std::filesystem;
using namespace penumbra::testing;

void write(const fs::path& path, const std::string& content) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
}

constexpr const char* kMoving = R"(shows = "everything moves"
asset = "generated:deforming.glb"
ground = true
[camera]
position = [3, 2, 5]
target = [0, 1, 0]
fov_y = 40
[light]
position = [0, 9, 9]
target = [0, 0, 0]
size = [1, 1]
[frames]
times = [0, 0.5, 1, 2]
[[track]]
target = "node:root.rotation"
times = [0, 1]
values = [[0, 0, 0], [0, 90, 0]]
interpolation = "step"
[[track]]
target = "light.size"
times = [0, 2]
values = [[1, 1], [2, 3]]
[[edge]]
from = [0, 0, 0]
to = [1, 0, 0]
half_width = 0.5
)";

}  // namespace

/// What the fuzzers start from: the sample assets as .glb and .gltf, scripts over them, and the
/// project's own scripts.
int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: fuzz_corpus FOLDER\n");
        return 2;
    }
    const fs::path out = argv[1];
    const std::pair<const char*, GltfFile> samples[] = {{"deforming", deformingFile()},
                                                        {"masked", maskedFile()},
                                                        {"sparse_instanced", sparseInstancedFile()},
                                                        {"lamp", lampFile()}};
    for (const auto& [name, file] : samples) {
        const std::string stem = name;
        write(out / "gltf" / (stem + ".glb"), file.glb());
        write(out / "gltf" / (stem + ".gltf"), file.gltf());
        write(out / "assets" / (stem + ".glb"), file.glb());
        write(out / "script" / (stem + ".toml"),
              "shows = \"a sample\"\nasset = \"generated:" + stem + ".glb\"\n");
    }
    write(out / "script" / "moving.toml", kMoving);
    const penumbra::SceneLibrary library = penumbra::SceneLibrary::standard();
    for (const std::string& id : library.ids())
        fs::copy_file(library.scripts / (id + ".toml"), out / "script" / (id + ".toml"),
                      fs::copy_options::overwrite_existing);
    return 0;
}
