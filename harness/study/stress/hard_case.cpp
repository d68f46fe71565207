#include "harness/study/stress/hard_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "harness/study/stress/invariants.hpp"
#include "harness/study/stress/toml_table.hpp"

namespace penumbra::stress {
namespace {

constexpr std::array kNoCases = {"elsewhere", "known", "random"};
constexpr int kMostFrames = 64;

/// Repeats what `work` refuses with the place of `key` in front.
template <class Work>
auto at(const TomlTable& table, const std::string& key, const Work& work) {
    try {
        return work();
    } catch (const InputError& e) {
        table.fail(key, e.what());
    }
}

Body readBody(TomlTable table) {
    Body body;
    body.kind = table.text("kind");
    const BodyKind& kind =
        at(table, "kind", [&]() -> const BodyKind& { return findBodyKind(body.kind); });
    for (const BodyNumber& number : kind.numbers)
        body.numbers[number.key] = number.fallback.empty() || table.has(number.key)
                                       ? table.numbers(number.key, number.count)
                                       : number.fallback;
    table.finish();
    at(table, "kind", [&] { shapeOf(body); });
    return body;
}

Motion readMotion(TomlTable table, const SmallScene& scene) {
    Motion motion;
    motion.target = table.text("target");
    motion.frames = static_cast<int>(table.number("frames", 2, kMostFrames));
    std::vector<std::string> targets = {"light.position", "light.size", "camera.position"};
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
        targets.push_back(fmt::format("node:body{}.translation", i));
    if (std::ranges::find(targets, motion.target) == targets.end())
        table.fail("target", fmt::format("unknown target '{}'; valid are {}",
                                         scene_detail::oneLine(motion.target, 60),
                                         scene_detail::listed(targets)));
    const std::size_t count = motion.target == "light.size" ? 2 : 3;
    motion.from = table.numbers("from", count);
    motion.to = table.numbers("to", count);
    table.finish();
    return motion;
}

/// Bodies, light, camera and motion of `table` over what `scene` has.
void readScene(TomlTable& table, SmallScene& scene) {
    for (TomlTable& body : table.tables("body")) scene.bodies.push_back(readBody(std::move(body)));
    if (table.has("light")) {
        TomlTable light = table.table("light");
        scene.lightPosition = light.vector("position");
        scene.lightTarget = light.vector("target");
        if (light.has("up")) scene.lightUp = light.vector("up");
        const std::vector<double> size = light.numbers("size", 2);
        scene.lightSize = {size[0], size[1]};
        if (!(size[0] >= 0.0 && size[1] >= 0.0 && (size[0] > 0.0) == (size[1] > 0.0)))
            light.fail("size", "size must be two lengths above 0, or [0, 0] for a point light");
        light.finish();
    }
    if (table.has("camera")) {
        TomlTable camera = table.table("camera");
        scene.cameraPosition = camera.vector("position");
        scene.cameraTarget = camera.vector("target");
        scene.fovYDeg = camera.number("fov_y", 1e-3, 179.0);
        camera.finish();
    }
    if (table.has("motion")) scene.motion = readMotion(table.table("motion"), scene);
}

std::size_t readIndex(TomlTable& table, const std::string& key, const SmallScene& scene) {
    if (scene.bodies.empty()) table.fail(key, "there are no bodies");
    return static_cast<std::size_t>(
        table.number(key, 0.0, static_cast<double>(scene.bodies.size() - 1)));
}

Variant readVariant(TomlTable table, const SmallScene& base) {
    Variant variant{"", base};
    SmallScene& scene = variant.scene;
    const auto given = [&](const std::string& key) {
        if (!table.has(key)) return false;
        variant.name += (variant.name.empty() ? "" : ", ") + key;
        return true;
    };
    const auto named = [&](const std::vector<double>& values) {
        for (const double v : values) variant.name += fmt::format(" {}", v);
        return values;
    };
    if (given("scale")) scene.placement.scale = named({table.number("scale", 1e-12, 1e12)})[0];
    if (given("rotate")) {
        const auto v = named(table.numbers("rotate", 3));
        scene.placement.rotateDeg = {v[0], v[1], v[2]};
    }
    if (given("offset")) {
        const auto v = named(table.numbers("offset", 3));
        scene.placement.offset = {v[0], v[1], v[2]};
    }
    if (given("mirror")) scene.placement.mirror = table.flag("mirror", false);
    if (given("shuffled")) scene.mesh.shuffled = table.flag("shuffled", false);
    if (given("duplicated")) scene.mesh.duplicated = table.flag("duplicated", false);
    if (given("split")) scene.mesh.split = table.flag("split", false);
    if (given("light_size")) {
        const auto v = named(table.numbers("light_size", 2));
        scene.lightSize = {v[0], v[1]};
    }
    if (given("move_light")) {
        const auto v = named(table.numbers("move_light", 3));
        scene.lightPosition += glm::dvec3(v[0], v[1], v[2]);
        scene.lightTarget += glm::dvec3(v[0], v[1], v[2]);
    }
    if (given("replace_body")) {
        const std::size_t index = readIndex(table, "replace_body", scene);
        scene.bodies[index] = readBody(table.table("by"));
    }
    if (given("drop_body"))
        scene.bodies.erase(scene.bodies.begin() +
                           static_cast<std::ptrdiff_t>(readIndex(table, "drop_body", scene)));
    table.finish();
    if (variant.name.empty())
        table.fail("",
                   "a [[variant]] must change something: scale, rotate, "
                   "offset, mirror, shuffled, duplicated, split, "
                   "light_size, move_light, replace_body, drop_body");
    return variant;
}

void readSetting(TomlTable table, HardCase& hardCase) {
    const std::string method = table.text("method");
    at(table, "method", [&] { findMethod(method); });
    TomlTable set = table.table("set");
    SettingChoice choice{{method}, {}, {}, false};
    for (const auto& [parameter, value] : set.assignments())
        choice.sets.push_back(fmt::format("{}.{}={}", method, parameter, value));
    table.finish();
    at(table, "set", [&] { hardCase.settings[method].push_back(expandSettings(choice).at(0)); });
}

}  // namespace

CaseLibrary CaseLibrary::standard() {
    return {SceneLibrary::standard().scripts / "stress"};
}

std::vector<std::string> CaseLibrary::ids() const {
    std::vector<std::string> ids;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        const std::string stem = entry.path().stem().string();
        if (entry.path().extension() == ".toml" &&
            std::ranges::find(kNoCases, stem) == kNoCases.end())
            ids.push_back(stem);
    }
    std::ranges::sort(ids);
    return ids;
}

HardCase CaseLibrary::load(const std::string& id) const {
    const std::vector<std::string> known = ids();
    if (std::ranges::find(known, id) == known.end())
        throw InputError(fmt::format("unknown case '{}'; the cases are {}",
                                     scene_detail::oneLine(id, 60), scene_detail::listed(known)));
    HardCase c;
    c.id = id;
    c.file = folder / (id + ".toml");
    TomlTable table = TomlTable::read(c.file);
    c.shows = table.text("shows");
    if (table.has("numbers"))
        for (const double n : table.numbers("numbers")) c.numbers.push_back(static_cast<int>(n));
    c.invariant = table.text("invariant");
    const Invariant& invariant =
        at(table, "invariant", [&]() -> const Invariant& { return findInvariant(c.invariant); });
    c.because = table.text("because");
    constexpr double kInfinite = 1e300;
    c.bound = invariant.bounded ? table.number("bound", 0.0, 1.0) : 0.0;
    c.allowed = table.number("allowed", 0.0, 0.0, 0.5);
    c.value = table.number("value", 0.0, 0.0, 1.0);
    c.edgeM = table.number("edge", c.edgeM, 0.0, kInfinite);
    if (table.has("direction")) c.direction = table.vector("direction");
    c.size = static_cast<int>(table.number("size", c.size, 4, 1024));
    if (table.has("needs"))
        c.needs = at(table, "needs", [&] {
            return EffectChoice::parse(fmt::format("{}", fmt::join(table.texts("needs"), ",")))
                .forced;
        });
    else
        (void)table.flag("needs", false);
    c.cheapest = table.flag("cheapest", false);
    c.others = table.flag("others", true);
    if (table.has("region")) {
        TomlTable region = table.table("region");
        c.region = {region.vector("lo"), region.vector("hi")};
        region.finish();
    }
    if (table.has("base")) {
        const std::string base = table.text("base");
        const auto file = folder / "base" / (base + ".toml");
        if (!std::filesystem::is_regular_file(file))
            table.fail("base", fmt::format("there is no {}", file.string()));
        TomlTable scene = TomlTable::read(file);
        readScene(scene, c.scene);
        scene.finish();
    }
    readScene(table, c.scene);
    for (TomlTable& variant : table.tables("variant"))
        c.variants.push_back(readVariant(std::move(variant), c.scene));
    for (TomlTable& setting : table.tables("setting")) readSetting(std::move(setting), c);
    if (invariant.variants == c.variants.empty())
        table.fail("invariant", fmt::format("'{}' {} a [[variant]]", c.invariant,
                                            invariant.variants ? "needs" : "does not take"));
    table.finish();
    at(table, "", [&] { c.scene.build(); });
    return c;
}

}  // namespace penumbra::stress
