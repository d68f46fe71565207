#include "core/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <optional>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/procedural_asset.hpp"
#include "core/scene/scene_builder.hpp"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace scene_detail;

std::string lowerExtension(const fs::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

std::string knownScenes(const SceneLibrary& library) {
    const std::vector<std::string> ids = library.ids();
    return ids.empty() ? fmt::format("none is in {}", library.scripts.string()) : listed(ids);
}

/// Where `script.asset` points to; the file need not exist.
fs::path assetPathOf(const Script& script, const SceneLibrary& library) {
    const auto after = [&](std::string_view prefix) -> std::optional<std::string> {
        if (!script.asset.starts_with(prefix)) return std::nullopt;
        return script.asset.substr(prefix.size());
    };
    fs::path path = script.file.parent_path() / script.asset;
    if (const auto name = after("generated:")) {
        if (name->empty() || fs::path(*name).filename() != *name) {
            failScript(script, script.assetWhere, "generated: is followed by a plain file name");
        }
        path = library.assets / *name;
    } else if (const auto absolute = after("package:")) {
        if (!fs::path(*absolute).is_absolute()) {
            failScript(script, script.assetWhere, "package: is followed by an absolute path");
        }
        path = *absolute;
    }
    const std::string extension = lowerExtension(path);
    if (extension != ".glb" && extension != ".gltf") {
        failScript(script, script.assetWhere,
                   fmt::format("'{}' is neither .glb nor .gltf", script.asset));
    }
    return path;
}

bool isProcedural(const Script& script) {
    try {
        return ProceduralAsset::parsed(script.asset).has_value();
    } catch (const std::invalid_argument& e) {
        failScript(script, script.assetWhere, e.what());
    }
}

std::shared_ptr<const Scene> loadScript(const fs::path& file, const SceneLibrary& library,
                                        const LoadOptions& options) {
    const Script script = readScript(file);
    if (isProcedural(script)) return buildScene(loadAsset(script.asset, options), script, options);
    const fs::path asset = assetPathOf(script, library);
    std::error_code error;
    if (!fs::exists(asset, error)) {
        if (!script.package.empty()) {
            throw AssetAbsent(
                oneLine(fmt::format("scene '{}' skipped: install Debian package {} (missing {})",
                                    file.stem().string(), script.package, asset.string())));
        }
        failScript(script, script.assetWhere,
                   fmt::format("asset {} does not exist", asset.string()));
    }
    return buildScene(loadAsset(asset, options), script, options);
}

}  // namespace

std::vector<std::string> SceneLibrary::ids() const {
    std::vector<std::string> out;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(scripts, error)) {
        if (entry.path().extension() == ".toml") out.push_back(entry.path().stem().string());
    }
    std::sort(out.begin(), out.end());
    return out;
}

SceneLibrary SceneLibrary::standard() {
    const auto folder = [](const char* variable, const char* otherwise) -> fs::path {
        const char* const value = std::getenv(variable);
        return value && *value ? value : otherwise;
    };
    return {folder("PENUMBRA_SCENES", PENUMBRA_SOURCE_DIR "/scenes"),
            folder("PENUMBRA_ASSETS", PENUMBRA_ASSET_DIR)};
}

std::shared_ptr<const Scene> loadScene(const std::string& idOrPath, const SceneLibrary& library,
                                       const LoadOptions& options) {
    const std::string extension = lowerExtension(idOrPath);
    const bool isScript = extension == ".toml";
    const bool isAsset = extension == ".glb" || extension == ".gltf";
    std::error_code error;
    if (isScript || isAsset) {
        if (!fs::exists(idOrPath, error)) failInput(idOrPath, "", "does not exist");
        return isScript ? loadScript(idOrPath, library, options)
                        : buildScene(loadAsset(idOrPath, options), std::nullopt, options);
    }
    if (idOrPath.empty() || idOrPath.find('/') != std::string::npos || !extension.empty()) {
        throw InputError(oneLine(
            fmt::format("'{}' is neither a .toml script, a .glb or .gltf asset nor a scene; "
                        "scenes are {}",
                        idOrPath, knownScenes(library)),
            4000));
    }
    const fs::path file = library.scripts / (idOrPath + ".toml");
    if (!fs::is_regular_file(file, error)) {
        throw InputError(oneLine(
            fmt::format("unknown scene '{}'; scenes are {}", idOrPath, knownScenes(library)),
            4000));
    }
    return loadScript(file, library, options);
}

}  // namespace penumbra
