#include "core/scene/script.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

struct TargetSpec {
    const char* name;  ///< what follows "node:NAME." for the node targets
    TrackTarget target;
    int components;
    bool ofNode;
};
constexpr std::array<TargetSpec, 9> kTargets = {{
    {"light.position", TrackTarget::lightPosition, 3, false},
    {"light.target", TrackTarget::lightTarget, 3, false},
    {"light.size", TrackTarget::lightSize, 2, false},
    {"camera.position", TrackTarget::cameraPosition, 3, false},
    {"camera.target", TrackTarget::cameraTarget, 3, false},
    {"camera.fov_y", TrackTarget::cameraFovY, 1, false},
    {"translation", TrackTarget::nodeTranslation, 3, true},
    {"rotation", TrackTarget::nodeRotation, 3, true},
    {"scale", TrackTarget::nodeScale, 3, true},
}};
const std::string kTargetNames =
    "light.position, light.target, light.size, camera.position, camera.target, camera.fov_y, "
    "node:NAME.translation, node:NAME.rotation, node:NAME.scale";
constexpr std::size_t kMaxFrames = 10'000;
constexpr std::uintmax_t kMaxScriptBytes = 16 << 20;
constexpr int kMaxDotsPerLine = 16;

std::string placeOf(const toml::node& node) {
    const toml::source_position at = node.source().begin;
    return fmt::format("{}:{}", std::max<unsigned>(at.line, 1), std::max<unsigned>(at.column, 1));
}

/// Of a number with one: digits on both sides that no further dot follows or precedes.
bool isDecimalPoint(const std::string& text, std::size_t dot) {
    const auto isDigit = [&](std::size_t i) {
        return i < text.size() && text[i] >= '0' && text[i] <= '9';
    };
    if (dot == 0 || !isDigit(dot - 1) || !isDigit(dot + 1)) return false;
    std::size_t first = dot - 1, last = dot + 1;
    while (first > 0 && isDigit(first - 1)) --first;
    while (isDigit(last + 1)) ++last;
    return (first == 0 || text[first - 1] != '.') &&
           (last + 1 == text.size() || text[last + 1] != '.');
}

class Reader {
  public:
    explicit Reader(const std::filesystem::path& file) { script_.file = file; }

    Script read() {
        const toml::table root = parsed();
        checkKeys(root, "a scene script",
                  {"shows", "figure", "asset", "package", "ground", "camera", "light", "frames",
                   "track", "edge"});
        script_.shows = text(root, "shows", "a scene script");
        script_.asset = text(root, "asset", "a scene script");
        script_.assetWhere = placeOf(*root.get("asset"));
        if (root.contains("figure")) script_.figure = text(root, "figure", "a scene script");
        if (root.contains("package")) script_.package = text(root, "package", "a scene script");
        if (const toml::node* ground = root.get("ground")) {
            if (!ground->is_boolean()) fail(*ground, "ground must be true or false");
            script_.ground = ground->as_boolean()->get();
        }
        if (const toml::node* camera = root.get("camera")) readCamera(tableOf(*camera, "camera"));
        if (const toml::node* light = root.get("light")) readLight(tableOf(*light, "light"));
        if (const toml::node* frames = root.get("frames")) {
            const toml::table& table = tableOf(*frames, "frames");
            checkKeys(table, "[frames]", {"times"});
            const toml::node& times = required(table, "times", "[frames]");
            script_.timesS = increasingTimes(times);
            if (script_.timesS.size() > kMaxFrames) {
                fail(times, fmt::format("at most {} frames are possible", kMaxFrames));
            }
        }
        if (const toml::node* tracks = root.get("track")) {
            if (!tracks->is_array_of_tables()) fail(*tracks, "tracks are written as [[track]]");
            for (const toml::node& track : *tracks->as_array()) readTrack(*track.as_table());
        }
        if (const toml::node* edges = root.get("edge")) {
            if (!edges->is_array_of_tables()) fail(*edges, "edges are written as [[edge]]");
            for (const toml::node& edge : *edges->as_array()) readEdge(*edge.as_table());
        }
        return std::move(script_);
    }

  private:
    [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
        failScript(script_, placeOf(node), what);
    }

    std::string content() const {
        const auto unreadable = [&] { failInput(script_.file, "", "is not a readable file"); };
        std::error_code error;
        // Opening a pipe would wait for who writes to it.
        if (!std::filesystem::is_regular_file(script_.file, error)) unreadable();
        const std::uintmax_t size = std::filesystem::file_size(script_.file, error);
        if (error) unreadable();
        if (size > kMaxScriptBytes) {
            failInput(script_.file, "",
                      fmt::format("has {} bytes; a script has at most {}", size, kMaxScriptBytes));
        }
        std::string text(size, '\0');
        std::ifstream in(script_.file, std::ios::binary);
        if (!in.read(text.data(), static_cast<std::streamsize>(size))) unreadable();
        return text;
    }

    /// toml++ 3.3 bounds the depth of values in each other, not that of dotted keys, and recurses
    /// through tables. Keys lie within a line, whatever it quotes.
    void refuseDeepKeys(const std::string& text) const {
        int line = 1, dots = 0;
        for (std::size_t i = 0; i < text.size(); ++i) {
            if (text[i] == '\n') {
                ++line;
                dots = 0;
            }
            const bool separates = text[i] == '.' && (i == 0 || text[i - 1] != '.');
            if (!separates || isDecimalPoint(text, i) || ++dots <= kMaxDotsPerLine) continue;
            failScript(
                script_, fmt::format("{}:1", line),
                fmt::format("has more than {} dots that are no decimal points", kMaxDotsPerLine));
        }
    }

    toml::table parsed() const {
        const std::string text = content();
        refuseDeepKeys(text);
        try {
            return toml::parse(text);
        } catch (const toml::parse_error& e) {
            failScript(script_,
                       fmt::format("{}:{}", e.source().begin.line, e.source().begin.column),
                       std::string(e.description()));
        }
    }

    void checkKeys(const toml::table& table, const std::string& owner,
                   const std::vector<std::string>& valid) const {
        for (const auto& [key, value] : table) {
            const toml::source_position at = key.source().begin;
            if (std::find(valid.begin(), valid.end(), key.str()) != valid.end()) continue;
            failScript(script_, fmt::format("{}:{}", at.line, at.column),
                       fmt::format("unknown key '{}' in {}; valid keys are {}",
                                   oneLine(std::string(key.str()), 60), owner, listed(valid)));
        }
    }

    const toml::node& required(const toml::table& table, const char* key,
                               const std::string& owner) const {
        const toml::node* node = table.get(key);
        if (!node) fail(table, fmt::format("{} needs '{}'", owner, key));
        return *node;
    }

    const toml::table& tableOf(const toml::node& node, const char* name) const {
        if (!node.is_table()) fail(node, fmt::format("'{0}' must be a table, [{0}]", name));
        return *node.as_table();
    }

    std::string text(const toml::table& table, const char* key, const std::string& owner) const {
        const toml::node& node = required(table, key, owner);
        if (!node.is_string()) fail(node, fmt::format("{} must be a string", key));
        const std::string& value = node.as_string()->get();
        if (value.empty()) fail(node, fmt::format("{} must not be empty", key));
        if (value.find('\n') != std::string::npos)
            fail(node, fmt::format("{} must be one line", key));
        return value;
    }

    double number(const toml::node& node, const std::string& name) const {
        const std::optional<double> value =
            node.is_number() ? node.value<double>() : std::optional<double>();
        if (!value || !std::isfinite(*value)) fail(node, name + " must be a finite number");
        if (!(std::abs(*value) <= kMaxExtentM)) {
            fail(node, fmt::format("{0} must be a number from -{2:g} to {2:g}, not {1:g}", name,
                                   *value, kMaxExtentM));
        }
        return *value;
    }

    glm::dvec4 numbers(const toml::node& node, int count, const std::string& name) const {
        glm::dvec4 out(0.0);
        if (count == 1) {
            out.x = number(node, name);
            return out;
        }
        const toml::array* array = node.as_array();
        if (!array || array->size() != static_cast<std::size_t>(count)) {
            fail(node, fmt::format("{} must be a list of {} numbers", name, count));
        }
        for (int c = 0; c < count; ++c) out[c] = number((*array)[c], name);
        return out;
    }

    glm::dvec3 point(const toml::table& table, const char* key, const std::string& owner) const {
        return glm::dvec3(numbers(required(table, key, owner), 3, key));
    }

    std::optional<glm::dvec3> optionalUp(const toml::table& table) const {
        const toml::node* node = table.get("up");
        if (!node) return std::nullopt;
        const glm::dvec3 up(numbers(*node, 3, "up"));
        if (!(glm::length(up) > 0.0)) fail(*node, "up must not be [0, 0, 0]");
        return up;
    }

    void checkSize(const toml::node& node, const glm::dvec4& size) const {
        const bool positive = size.x > 0.0 && size.y > 0.0;
        const bool zero = size.x == 0.0 && size.y == 0.0;
        if (!positive && !zero) {
            fail(node, "size must be two lengths in metres above 0, or [0, 0] for a point light");
        }
    }

    void checkFovY(const toml::node& node, double degrees) const {
        if (!(degrees > 0.0 && degrees < 180.0)) {
            fail(node, "fov_y must be an angle in degrees above 0 and below 180");
        }
    }

    void readCamera(const toml::table& table) {
        checkKeys(table, "[camera]", {"position", "target", "up", "fov_y"});
        ScriptCamera camera;
        camera.where = placeOf(table);
        camera.position = point(table, "position", "[camera]");
        camera.target = point(table, "target", "[camera]");
        camera.up = optionalUp(table);
        const toml::node& fovY = required(table, "fov_y", "[camera]");
        camera.fovYDegrees = number(fovY, "fov_y");
        checkFovY(fovY, camera.fovYDegrees);
        if (camera.position == camera.target) {
            fail(required(table, "target", "[camera]"), "target must differ from position");
        }
        script_.camera = camera;
    }

    void readLight(const toml::table& table) {
        checkKeys(table, "[light]", {"position", "target", "up", "size"});
        ScriptLight light;
        light.where = placeOf(table);
        light.position = point(table, "position", "[light]");
        light.target = point(table, "target", "[light]");
        light.up = optionalUp(table);
        const toml::node& size = required(table, "size", "[light]");
        const glm::dvec4 metres = numbers(size, 2, "size");
        checkSize(size, metres);
        light.size = glm::dvec2(metres);
        if (light.position == light.target) {
            fail(required(table, "target", "[light]"), "target must differ from position");
        }
        script_.light = light;
    }

    std::vector<double> increasingTimes(const toml::node& node) const {
        const toml::array* array = node.as_array();
        if (!array || array->empty()) fail(node, "times must be a list of at least one number");
        std::vector<double> times;
        for (const toml::node& element : *array) {
            const double time = number(element, "times");
            if (!times.empty() && time <= times.back()) {
                fail(element,
                     fmt::format("times must increase; {} does not exceed {}", time, times.back()));
            }
            times.push_back(time);
        }
        return times;
    }

    void readTrack(const toml::table& table) {
        checkKeys(table, "[[track]]", {"target", "times", "values", "interpolation"});
        const std::string name = text(table, "target", "[[track]]");
        const toml::node& targetNode = required(table, "target", "[[track]]");
        ScriptTrack track;
        track.where = placeOf(targetNode);
        std::string property = name;
        const bool ofNode = name.starts_with("node:");
        if (ofNode) {
            const std::size_t dot = name.rfind('.');  // node names may hold dots
            if (dot != std::string::npos) {
                track.node = name.substr(5, dot - 5);
                property = name.substr(dot + 1);
            }
        }
        const auto spec = std::find_if(kTargets.begin(), kTargets.end(), [&](const TargetSpec& s) {
            return s.ofNode == ofNode && s.name == property;
        });
        if (spec == kTargets.end()) {
            fail(targetNode, fmt::format("unknown target '{}'; valid targets are {}",
                                         oneLine(name, 80), kTargetNames));
        }
        if (!targets_.insert(name).second) {
            fail(targetNode, fmt::format("'{}' has a track already", oneLine(name, 80)));
        }
        track.target = spec->target;
        if (!script_.light && name.starts_with("light.")) {
            fail(targetNode, name + " needs a [light] table to start from");
        }
        if (!script_.camera && name.starts_with("camera.")) {
            fail(targetNode, name + " needs a [camera] table to start from");
        }
        track.curve.times = increasingTimes(required(table, "times", "[[track]]"));
        readValues(table, *spec, track.curve);
        if (const toml::node* interpolation = table.get("interpolation")) {
            const std::string kind = text(table, "interpolation", "[[track]]");
            if (kind != "linear" && kind != "step") {
                fail(*interpolation,
                     fmt::format("unknown interpolation '{}'; valid are linear, step",
                                 oneLine(kind, 40)));
            }
            if (kind == "step") track.curve.interpolation = Interpolation::step;
        }
        script_.tracks.push_back(std::move(track));
    }

    void readValues(const toml::table& table, const TargetSpec& spec, Curve& curve) const {
        const toml::node& node = required(table, "values", "[[track]]");
        const toml::array* array = node.as_array();
        if (!array || array->size() != curve.times.size()) {
            fail(node, fmt::format("values must be a list with one entry for each of the {} times",
                                   curve.times.size()));
        }
        for (const toml::node& element : *array) {
            const glm::dvec4 value = numbers(element, spec.components, "each of values");
            if (spec.target == TrackTarget::lightSize) checkSize(element, value);
            if (spec.target == TrackTarget::cameraFovY) checkFovY(element, value.x);
            curve.values.push_back(value);
        }
    }

    void readEdge(const toml::table& table) {
        checkKeys(table, "[[edge]]", {"from", "to", "half_width"});
        ShadowEdge edge;
        edge.from = point(table, "from", "[[edge]]");
        edge.to = point(table, "to", "[[edge]]");
        if (edge.from == edge.to) {
            fail(required(table, "to", "[[edge]]"), "to must differ from from");
        }
        const toml::node& halfWidth = required(table, "half_width", "[[edge]]");
        edge.halfWidthM = number(halfWidth, "half_width");
        if (!(edge.halfWidthM > 0.0)) {
            fail(halfWidth, "half_width must be a length in metres above 0");
        }
        script_.edges.push_back(edge);
    }

    Script script_;
    std::set<std::string> targets_;
};

}  // namespace

Script readScript(const std::filesystem::path& file) {
    return Reader(file).read();
}

void failScript(const Script& script, const std::string& where, const std::string& what) {
    throw InputError(oneLine(fmt::format("{}:{}: {}", script.file.string(), where, what), 2000));
}

}  // namespace penumbra::scene_detail
