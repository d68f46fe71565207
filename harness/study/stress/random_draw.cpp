#include "harness/study/stress/random_draw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/error.hpp"
#include "core/frame/light_centre.hpp"
#include "core/sampling/sampling.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::stress {
namespace {

/// Numbers of one draw, a pure function of seed, index and how many were taken before.
class Dice {
  public:
    Dice(std::uint32_t seed, std::uint32_t index) : seed_(hash(seed, index)) {}
    double unit() { return static_cast<double>(toUnitFloat(hash(seed_, taken_++))); }
    double between(double lo, double hi) { return lo + (hi - lo) * unit(); }
    double logBetween(double lo, double hi) { return lo * std::pow(hi / lo, unit()); }
    bool chance(double p) { return unit() < p; }
    std::size_t below(std::size_t n) {
        return std::min(n - 1, static_cast<std::size_t>(unit() * static_cast<double>(n)));
    }
    glm::dvec3 inBox(const glm::dvec3& lo, const glm::dvec3& hi) {
        const double x = between(lo.x, hi.x), y = between(lo.y, hi.y), z = between(lo.z, hi.z);
        return {x, y, z};
    }

  private:
    std::uint32_t seed_, taken_ = 0;
};

std::vector<double> list(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

Body randomBody(Dice& dice) {
    const glm::dvec3 at = dice.inBox({-0.8, 0.05, -0.8}, {0.8, 1.4, 0.8});
    switch (dice.below(4)) {
        case 0:
            return {"box",
                    {{"lo", list(at)},
                     {"hi", list(at + dice.inBox(glm::dvec3(0.02), glm::dvec3(0.6)))}}};
        case 1:
            return {"quad",
                    {{"corner", list(at)},
                     {"edge_u", list(dice.inBox(glm::dvec3(-0.7), glm::dvec3(0.7)))},
                     {"edge_v", list(dice.inBox(glm::dvec3(-0.7), glm::dvec3(0.7)))}}};
        case 2:
            return {"sphere",
                    {{"centre", list(at)},
                     {"radius", {dice.between(0.03, 0.3)}},
                     {"rings", {static_cast<double>(4 + dice.below(5))}}}};
        default: {
            // As thin as float can tell apart, or thicker.
            const glm::dvec3 to = dice.inBox({-0.8, 0.05, -0.8}, {0.8, 1.4, 0.8});
            const double width = dice.logBetween(1e-8, 1e-2);
            return {"triangle",
                    {{"a", list(at)},
                     {"b", list(to)},
                     {"c", list(0.5 * (at + to) +
                                width * dice.inBox(glm::dvec3(-1.0), glm::dvec3(1.0)))}}};
        }
    }
}

Body randomFloor(Dice& dice) {
    const double side = dice.between(0.8, 1.5);
    if (dice.chance(0.5)) return {"box", {{"lo", {-side, -0.1, -side}}, {"hi", {side, 0.0, side}}}};
    return {"quad",
            {{"corner", {-side, dice.between(-0.2, 0.0), side}},
             {"edge_u", {2.0 * side, dice.between(-0.2, 0.2), 0.0}},
             {"edge_v", {0.0, dice.between(-0.2, 0.2), -2.0 * side}}}};
}

SmallScene randomScene(Dice& dice) {
    SmallScene scene;
    scene.bodies.push_back(randomFloor(dice));
    const std::size_t casters = dice.below(5);
    for (std::size_t i = 0; i < casters; ++i) scene.bodies.push_back(randomBody(dice));
    scene.lightPosition = dice.inBox({-1.2, 1.6, -1.2}, {1.2, 3.5, 1.2});
    scene.lightTarget = dice.inBox({-0.6, 0.0, -0.6}, {0.6, 0.2, 0.6});
    const double side = dice.logBetween(1e-4, 1.0);
    scene.lightSize =
        dice.chance(0.2) ? glm::dvec2(0.0) : glm::dvec2(side, side * dice.logBetween(0.05, 1.0));
    scene.cameraPosition = dice.inBox({-2.0, 0.8, 1.2}, {2.0, 3.0, 3.0});
    scene.cameraTarget = dice.inBox({-0.3, 0.0, -0.3}, {0.3, 0.3, 0.3});
    scene.fovYDeg = dice.between(20.0, 60.0);
    if (dice.chance(0.5)) {
        scene.placement.scale = dice.logBetween(1e-3, 1e3);
        scene.placement.rotateDeg = dice.inBox(glm::dvec3(-180.0), glm::dvec3(180.0));
        scene.placement.offset = dice.inBox(glm::dvec3(-1e6), glm::dvec3(1e6));
    }
    return scene;
}

double parsed(const std::string& text) {
    double value = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

/// A value of `parameter`: its least, or something up to twice its default.
std::string randomValue(const Parameter& parameter, Dice& dice) {
    const std::vector<std::string> extremes = parameter.extremes();
    if (parameter.type() == "choice" || parameter.type() == "bool")
        return extremes[dice.below(extremes.size())];
    const double lo = parsed(extremes.front()), hi = parsed(extremes.back());
    const double usual = parsed(parameter.defaultText());
    if (dice.chance(0.25)) return extremes.front();
    // What costs: twice the usual at most; sizes in texels not even that.
    const double most = std::min(
        hi, parameter.unit() == "texels" && parameter.type() == "int" ? usual : 2.0 * usual + 4.0);
    const double value = dice.between(lo, most);
    return parameter.type() == "int" ? fmt::format("{:.0f}", std::floor(value))
                                     : fmt::format("{:.6g}", value);
}

/// Means over the pixels asked. Of the horizon's pixels `meanAbsolute` counts nothing: one map
/// knows no more of the light below a receiver's plane than the hard shadow does, and as little is
/// scored.
struct Errors {
    double meanAbsolute = 0.0, rms = 0.0;
};

template <class Visibility>
Errors errorsOf(const StageFrame& frame, const Visibility& visibilityAt) {
    Errors errors;
    for (const std::size_t i : frame.asked()) {
        const double e = std::abs(visibilityAt(i) - static_cast<double>(frame.exact()[i]));
        if (frame.frame().gbuffer.mask[i] == PixelClass::scored) errors.meanAbsolute += e;
        errors.rms += e * e;
    }
    const double n = static_cast<double>(std::max<std::size_t>(1, frame.asked().size()));
    return {errors.meanAbsolute / n, std::sqrt(errors.rms / n)};
}

std::optional<DrawFailure> checkRange(const StageFrame& frame, const Image& image) {
    for (const std::size_t i : frame.asked())
        if (!(image[i] >= 0.0f && image[i] <= 1.0f))
            return DrawFailure{"range", image[i], 0.0, fmt::format("pixel {} is {}", i, image[i])};
    return std::nullopt;
}

std::optional<DrawFailure> checkLit(const StageFrame& frame, const Image& image) {
    // On the horizon the floor's own body is in the way.
    for (const std::size_t i : frame.asked())
        if (frame.frame().gbuffer.mask[i] == PixelClass::scored && image[i] != 1.0f)
            return DrawFailure{"lit", 1.0 - image[i], 0.0,
                               fmt::format("no caster, but pixel {} is {}", i, image[i])};
    return std::nullopt;
}

std::optional<DrawFailure> checkHard(const Draw& draw, const StageFrame& frame,
                                     const Image& image) {
    // A hundredth of the scene's size at the receiver: several texels of any method's default map.
    const double edgeM = 0.02 * draw.scene.placement.scale;
    // A sliver that a map misses, or sees as a whole texel, is thinner than that edge.
    std::size_t wrong = 0, first = 0;
    for (const std::size_t i : frame.asked()) {
        const auto seen = centreSeen(frame.frame(), i, edgeM);
        if (!seen || image[i] == (*seen ? 1.0f : 0.0f)) continue;
        if (wrong++ == 0) first = i;
    }
    // 25 rays do not find every corner within the edge's reach: one pixel in 200 is let pass.
    const double share = static_cast<double>(wrong) /
                         static_cast<double>(std::max<std::size_t>(1, frame.asked().size()));
    if (share <= 0.005) return std::nullopt;
    return DrawFailure{"hard", share, 0.005, fmt::format("pixel {} is {}", first, image[first])};
}

std::optional<DrawFailure> checkTruth(const Draw& draw, const StageFrame& frame, const Image& image,
                                      const TruthBounds& bounds) {
    const TruthBound& bound = bounds.of(draw.method);
    const Errors errors = errorsOf(frame, [&](std::size_t i) { return image[i]; });
    if (!bound.samples.empty()) {
        const auto method = draw.setting().make();
        const auto parameter = std::ranges::find(method->parameters(), bound.samples,
                                                 [](const Parameter* p) { return p->id(); });
        const double most = bound.rmsFactor / std::sqrt(std::max(1.0, (*parameter)->number()));
        if (errors.rms <= most) return std::nullopt;
        return DrawFailure{"truth", errors.rms, most, "rms error"};
    }
    const Errors hard = errorsOf(frame, [&](std::size_t i) {
        return centreSeen(frame.frame(), i, 0.0).value_or(false) ? 1.0 : 0.0;
    });
    const double most = hard.meanAbsolute + bound.meanBeyondHard;
    if (errors.meanAbsolute <= most) return std::nullopt;
    return DrawFailure{"truth", errors.meanAbsolute, most, "mean error"};
}

}  // namespace

Setting Draw::setting() const {
    SettingChoice choice{{method}, {}, {}, false};
    for (const auto& [parameter, value] : assignments)
        choice.sets.push_back(fmt::format("{}.{}={}", method, parameter, value));
    return expandSettings(choice).at(0);
}

Draw drawRandom(std::uint32_t seed, std::uint32_t index, const std::vector<std::string>& methods) {
    Dice dice(seed, index);
    Draw draw;
    draw.method = methods[index % methods.size()];
    draw.scene = randomScene(dice);
    if (dice.chance(0.5)) {
        const auto method = findMethod(draw.method).make();
        for (const Parameter* parameter : method->parameters())
            if (dice.chance(0.3))
                draw.assignments.emplace_back(parameter->id(), randomValue(*parameter, dice));
    }
    return draw;
}

DrawResult checkDraw(const Draw& draw, const TruthBounds& bounds) {
    const Stage stage(draw.scene.build(), draw.size, 1);
    const Setting setting = draw.setting();
    const StageFrame& frame = *stage.frames()[0];
    try {
        const Image image = render(setting, stage)[0];
        if (auto failure = checkRange(frame, image)) return {failure, false, ""};
        const Image again = render(setting, stage)[0];
        for (const std::size_t i : frame.asked())
            if (std::memcmp(&image[i], &again[i], sizeof(float)) != 0)
                return {DrawFailure{"repeats", std::abs(image[i] - again[i]), 0.0,
                                    fmt::format("pixel {} is {}, then {}", i, image[i], again[i])},
                        false, ""};
        // A bias of 0, or a mesh taken as it is, may be wrong in all that follows, and says so.
        if (!draw.assignments.empty()) return {};
        const bool alone = draw.scene.bodies.size() == 1;
        if (alone) return {checkLit(frame, image), false, ""};
        if (frame.frame().light.isPoint()) return {checkHard(draw, frame, image), false, ""};
        return {checkTruth(draw, frame, image, bounds), false, ""};
    } catch (const Unsupported& e) {
        return {std::nullopt, true, e.what()};
    } catch (const std::exception& e) {
        return {DrawFailure{"throws", 1.0, 0.0, scene_detail::oneLine(e.what())}, false, ""};
    }
}

}  // namespace penumbra::stress
