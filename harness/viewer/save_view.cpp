#include "harness/viewer/save_view.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "core/error.hpp"
#include "core/scene/gltf_export.hpp"
#include "core/scene/script.hpp"
#include "harness/run/files.hpp"
#include "harness/run/suite.hpp"
#include "harness/viewer/camera_control.hpp"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace scene_detail;

std::string numbers(const glm::dvec3& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

std::string tomlString(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

std::string cameraTable(const Camera& camera, const glm::dvec3& origin) {
    const glm::dvec3 position = camera.position + origin;
    return fmt::format("\n[camera]\nposition = {}\ntarget   = {}\nup       = {}\nfov_y    = {}\n",
                       numbers(position), numbers(position - camera.back), numbers(camera.up),
                       glm::degrees(camera.fovYRad));
}

std::string lightTable(const AreaLight& light, const glm::dvec3& origin) {
    const glm::dvec3 position = light.centre + origin;
    return fmt::format(
        "\n[light]\nposition = {}\ntarget   = {}\nup       = {}\nsize     = [{}, {}]\n",
        numbers(position), numbers(position + light.normal()), numbers(light.axisV),
        2.0 * light.halfU, 2.0 * light.halfV);
}

const char* nodeProperty(TrackTarget target) {
    switch (target) {
        case TrackTarget::nodeTranslation:
            return "translation";
        case TrackTarget::nodeRotation:
            return "rotation";
        case TrackTarget::nodeScale:
            return "scale";
        default:
            return nullptr;  // of the light or the camera, which are said outright
    }
}

std::string nodeTrack(const ScriptTrack& track) {
    const char* const property = nodeProperty(track.target);
    if (!property) return "";
    std::string times, values;
    for (std::size_t i = 0; i < track.curve.times.size(); ++i) {
        times += fmt::format("{}{}", i ? ", " : "", track.curve.times[i]);
        values += (i ? ", " : "") + numbers(glm::dvec3(track.curve.values[i]));
    }
    return fmt::format(
        "\n[[track]]\ntarget = {}\ntimes  = [{}]\nvalues = [{}]\ninterpolation = \"{}\"\n",
        tomlString(fmt::format("node:{}.{}", track.node, property)), times, values,
        track.curve.interpolation == Interpolation::step ? "step" : "linear");
}

/// The asset as a script in `folder` names it: as the session's own script does, where that does
/// not depend on the folder.
std::string assetName(const Scene& scene, const std::optional<Script>& script) {
    if (script && script->asset.find(':') != std::string::npos) return script->asset;
    return fs::absolute(scene.asset).lexically_normal().string();
}

bool hasGround(const Scene& scene) {
    return std::ranges::any_of(scene.chosen,
                               [](const std::string& note) { return note.starts_with("ground:"); });
}

struct Text {
    std::string script, glb;
};

Text textOf(const ViewSession& session, const std::string& glbName) {
    const Scene& scene = session.scene();
    const SceneFrame& state = session.state();
    std::optional<Script> script;
    if (scene.source != scene.asset) script = readScript(scene.source);
    const bool ownLight = script && script->light;
    const bool ownCamera = script && script->camera;
    if (session.cameraEdited() && state.camera.kind == Camera::Kind::orthographic)
        throw InputError(
            "an orthographic camera that was moved cannot be said in a scene script; reset it");

    Text out;
    const std::string what = fmt::format("a view of {}, saved from the window", scene.id);
    // A light of the asset would stay in the scene as a surface beside the script's, and a ground
    // plate takes its size from the light.
    const bool byReference = !session.lightEdited() || (ownLight && !hasGround(scene));
    out.script = fmt::format("shows  = {}\n", tomlString(what));
    if (byReference) {
        out.script += fmt::format("asset  = {}\n", tomlString(assetName(scene, script)));
        if (script && !script->package.empty())
            out.script += fmt::format("package = {}\n", tomlString(script->package));
        if (hasGround(scene)) out.script += "ground = true\n";
        if (session.cameraEdited() || ownCamera)
            out.script += cameraTable(state.camera, scene.origin);
        if (ownLight) out.script += lightTable(state.light, scene.origin);
        if (state.timeS != 0.0)
            out.script += fmt::format("\n[frames]\ntimes = [{}]\n", state.timeS);
        if (script)
            for (const ScriptTrack& track : script->tracks) out.script += nodeTrack(track);
        return out;
    }
    out.script += fmt::format("asset  = {}\n", tomlString(glbName));
    // A clipped camera or an orthographic one is the asset's own and stays as it is.
    const double aspect = static_cast<double>(session.width()) / session.height();
    if (state.camera == moved(state.camera, glm::dvec3(0.0)))
        out.script += cameraTable(state.camera, scene.origin);
    if (state.light.isPoint()) out.script += lightTable(state.light, scene.origin);
    out.glb = exportGltf(scene, state, withClipPlanes(scene, state, 0.0), aspect);
    return out;
}

std::string readAll(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

/// Byte offset of a place that toml++ names; lines and columns from 1, columns in code points.
std::size_t offsetOf(const std::string& text, const toml::source_position& at) {
    std::size_t offset = 0;
    for (toml::source_index line = 1; line < at.line; ++line) offset = text.find('\n', offset) + 1;
    for (toml::source_index column = 1; column < at.column; ++column) {
        ++offset;
        while (offset < text.size() && (static_cast<unsigned char>(text[offset]) & 0xc0) == 0x80)
            ++offset;
    }
    return offset;
}

}  // namespace

std::vector<fs::path> saveView(const ViewSession& session, const fs::path& path) {
    if (path.extension() != ".toml")
        throw InputError(fmt::format("{}: a scene script's name ends with .toml", path.string()));
    const fs::path glb = fs::path(path).replace_extension(".glb");
    const Text text = textOf(session, glb.filename().string());
    std::vector<fs::path> files{path};
    if (!text.glb.empty()) {
        writeFileAtomically(glb, text.glb);
        files.push_back(glb);
    }
    writeFileAtomically(path, text.script);
    return files;
}

void addToSuite(const SceneLibrary& library, const std::string& suite, const std::string& sceneId) {
    if (suite.empty() || suite.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVW"
                                                 "XYZ0123456789_-") != std::string::npos)
        throw InputError(
            fmt::format("suite '{}': a name has letters, digits, _ and - only", suite));
    if (!std::ranges::count(library.ids(), sceneId))
        throw InputError(fmt::format("scene '{}' is not in {}", sceneId, library.scripts.string()));
    const fs::path file = library.scripts / "suites" / (suite + ".toml");
    if (!fs::exists(file)) {
        fs::create_directories(file.parent_path());
        writeFileAtomically(file, fmt::format("shows = \"views that were saved from the window\"\n"
                                              "scenes = [\n    {},\n]\n",
                                              tomlString(sceneId)));
        return;
    }
    const Suite known = loadSuite(suite, library);
    if (std::ranges::count(known.scenes, sceneId))
        throw InputError(fmt::format("suite '{}' has scene '{}' already", suite, sceneId));
    std::string text = readAll(file);
    const toml::table table = toml::parse(text);
    const toml::array& scenes = *table["scenes"].as_array();
    text.insert(offsetOf(text, scenes.back().source().end), ", " + tomlString(sceneId));
    // Whatever the file looked like: what would be written must say the same and one scene more.
    std::vector<std::string> expected = known.scenes, found;
    expected.push_back(sceneId);
    const toml::table extended = toml::parse(text);
    for (const toml::node& scene : *extended["scenes"].as_array())
        found.push_back(scene.value_or(std::string()));
    if (found != expected)
        throw InputError(fmt::format("{}: its list of scenes cannot be added to", file.string()));
    writeFileAtomically(file, text);
}

}  // namespace penumbra
