// How near shade passes come to the fetches they make: each method's shade pass beside a bare
// shader (shaders/common/bare_fetches.glsl) that fetches as often per pixel, from a texture of the
// same size and format, spread as widely. Counters: `of_bare`, bare time over shade time, the
// median of pairs measured one right after the other; the least of both times, and fetches per
// second at those.
//
// Where the number of fetches depends on the pixel, the bare shader reads the method's answer and
// makes as many as a pixel of that answer makes at least, in the same pixels: less than 1 is the
// answer only where all of them were made; 1 may have taken more than it is credited with.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/passes/depth_pass.hpp"
#include "harness/bench/stage.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra::bench {
namespace {

constexpr int kPixels = 512;

enum class Fetch { nearest, compare, table, layers };

/// A setting, and the fetches that it makes by its own account.
struct Case {
    std::string name, method;
    Assignments settings;
    Fetch fetch;
    int side = 0;        ///< side^2 fetches, or the number of layers
    int looks = 1;       ///< pixels with shadow: so many times,
    int filterSide = 0;  ///< and filterSide^2 more
    /// The kernel reaches out to the pyramid from the receiver to the light, cut at the nearest
    /// caster, and at most to so many sizes of the light.
    double widest = 0.0;
};

const std::vector<Case>& cases() {
    static const std::vector<Case> all = {
        {"pcf_grid", "pcf", {}, Fetch::nearest, 7, 1, 0, 0.25},
        {"pcf_vogel", "pcf", {{"pattern", "vogel"}}, Fetch::nearest, 7, 1, 0, 0.25},
        {"pcf_hardware", "pcf", {{"compare", "hardware"}}, Fetch::compare, 7, 1, 0, 0.25},
        // Without the pyramid, whose reads are no taps of the map.
        {"pcss", "pcss", {{"pyramid", "off"}}, Fetch::nearest, 8, 1, 10, 4.0},
        // Each of up to three boxes of 4 x 4 cells takes the sums at 7 x 7 corners.
        {"vsm", "vsm", {}, Fetch::table, 7, 3, 0, 0.5},
        {"light_sampled", "light_sampled", {}, Fetch::layers, 16},
    };
    return all;
}

int mapSizeOf(const ShadowMethod& method) {
    for (const Parameter* parameter : method.parameters())
        if (parameter->id() == "map_size") return static_cast<int>(parameter->number());
    throw std::logic_error("no map_size");
}

gl::Program bareProgram(const Case& c) {
    if (c.fetch == Fetch::layers) return gl::Program::graphics("common/bare_fetches.glsl");
    std::vector<std::string> defines = {"SIDE " + std::to_string(c.side)};
    defines.push_back("LOOKS " + std::to_string(c.looks));
    if (c.filterSide > 0) defines.push_back("FILTER_SIDE " + std::to_string(c.filterSide));
    if (c.fetch == Fetch::compare) defines.emplace_back("FETCH_COMPARE");
    if (c.fetch == Fetch::table) defines.emplace_back("FETCH_TABLE");
    return gl::Program::graphics("common/bare_fetches.glsl", defines);
}

/// The method's answer as a texture, and how many fetches it stands for.
struct Answer {
    gl::Texture texture;
    double fetches = 0.0;
};

Answer answerOf(const Case& c, const Stage& stage, const TextureTarget& target) {
    Answer answer{gl::Texture::create2D(GL_R32F, kPixels, kPixels)};
    const std::vector<float> pixels = target.read();
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(answer.texture.id(), 0, 0, 0, kPixels, kPixels, GL_RED, GL_FLOAT,
                        pixels.data());
    const double least = c.fetch == Fetch::layers ? c.side : c.side * c.side;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const PixelClass shown = stage.gbuffer.mask[i];
        if (shown != PixelClass::scored && shown != PixelClass::horizon) continue;
        answer.fetches += least;
        if (pixels[i] < 1.0f) answer.fetches += (c.looks - 1) * least + c.filterSide * c.filterSide;
    }
    return answer;
}

void overBareShader(benchmark::State& state, const std::string& id, const Case& c) {
    needContext();
    const Stage stage(id, kPixels);
    const TextureTarget target(kPixels, kPixels);
    const auto [method, plan] = stage.act(c.method, c.settings);
    method->build(stage.frame, plan);
    method->shade(stage.frame, plan, target);
    const Answer answer = answerOf(c, stage, target);

    const int mapSize = mapSizeOf(*method);
    const SideBounds& bounds = stage.frame.lightBounds.whole;
    const AreaLight& light = stage.frame.light;
    const glm::dvec2 lightHalfM(light.halfU, light.halfV);
    const double widest = std::min(c.widest, bounds.receiverFarM / bounds.casterNearM - 1.0);
    DepthPass maps(plan);
    maps.render(stage.frame,
                std::vector<LightView>(c.fetch == Fetch::layers ? c.side : 1,
                                       LightView::fit(stage.frame, widest * lightHalfM, mapSize)),
                mapSize);
    const gl::Texture table =
        gl::Texture::createArray(GL_RG32UI, mapSize + 1, mapSize + 1, maps.map().layers());
    const gl::Sampler comparing = comparingSampler();
    const gl::Program bare = bareProgram(c);

    std::vector<double> bareMs, shadeMs, ofBare;
    for (auto _ : state) {
        bare.use();
        maps.bind(bare, 0);
        if (c.fetch == Fetch::table) table.bind(1);
        if (c.fetch == Fetch::compare) {
            maps.map().bind(1);
            glBindSampler(1, comparing.id());
        }
        answer.texture.bind(3);
        bare.set("lightHalfM", glm::vec2(lightHalfM));
        bare.set("casterNearM", static_cast<float>(bounds.casterNearM));
        bare.set("widest", static_cast<float>(c.widest));
        bare.set("fetches", c.side);
        bareMs.push_back(fencedMs([&] { target.draw(bare, stage.textures); }));
        glBindSampler(1, 0);
        shadeMs.push_back(fencedMs([&] { method->shade(stage.frame, plan, target); }));
        ofBare.push_back(bareMs.back() / shadeMs.back());
    }
    const double leastBareMs = *std::ranges::min_element(bareMs);
    const double leastShadeMs = *std::ranges::min_element(shadeMs);
    const auto middle = ofBare.begin() + static_cast<std::ptrdiff_t>(ofBare.size() / 2);
    std::ranges::nth_element(ofBare, middle);
    state.counters["bare_ms"] = leastBareMs;
    state.counters["shade_ms"] = leastShadeMs;
    state.counters["bare_fetches_per_s"] = 1e3 * answer.fetches / leastBareMs;
    state.counters["shade_fetches_per_s"] = 1e3 * answer.fetches / leastShadeMs;
    state.counters["of_bare"] = *middle;
}

const auto registered = [] {
    for (const char* scene : {"contact", "half_plane"})
        for (const Case& c : cases())
            benchmark::RegisterBenchmark(("shade/" + std::string(scene) + '/' + c.name).c_str(),
                                         overBareShader, std::string(scene), c)
                ->Iterations(41)
                ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra::bench
