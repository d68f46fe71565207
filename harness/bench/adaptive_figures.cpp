// The counterparts of Schwaerzler 2009, figs 1 and 7, and the tree over the light for three views,
// as PNG files in the working folder (docs/METHODS.md shows them): schwaerzler_<case>.png has
// regular sampling to the left and the paper's own algorithm to the right; light_trees.png has what
// each camera sees and below it the parts of the light with a dot per map.

#include <fmt/format.h>

#include <string>

#include "core/image/image.hpp"
#include "harness/bench/adaptive_stage.hpp"

namespace penumbra::bench {
namespace {

constexpr int kTextPx = 14;

Image grey(int width, int height) {
    Image image = Image::withChannels(width, height, {"R", "G", "B"});
    std::ranges::fill(image.pixels, 1.0f);
    return image;
}

void fill(Image& image, int x0, int y0, int x1, int y1, float r, float g, float b) {
    for (int y = std::max(y0, 0); y < std::min(y1, image.height); ++y)
        for (int x = std::max(x0, 0); x < std::min(x1, image.width); ++x) {
            image.at(x, y, 0) = r;
            image.at(x, y, 1) = g;
            image.at(x, y, 2) = b;
        }
}

/// Visibility, every `step`-th pixel of it; surfaces facing away are dark, background is white.
void paste(Image& image, int left, const std::vector<float>& visibility, int width, int height,
           int step) {
    for (int y = 0; y < height / step; ++y)
        for (int x = 0; x < width / step; ++x) {
            const float v = visibility[static_cast<std::size_t>(y * step * width + x * step)];
            fill(image, left + x, y, left + x + 1, y + 1, v, v, v);
        }
}

void paperFigure(benchmark::State& state, const Case& c) {
    needContext();
    const Stage stage(c.scene, kWidth, kHeight, c.linear ? makeLinear : nullptr);
    const Sparse truth(stage);
    const Settings settings = settingsOf(c, true);
    Player adaptive(stage, "adaptive_light_sampled",
                    with(settings.adaptive, "epsilon",
                         std::to_string(epsilonFor(stage, settings.adaptive, c.maps))));
    Player regular(stage, "light_sampled",
                   with(settings.regular, "samples", std::to_string(c.regularMaps)));
    for (auto _ : state) {
        adaptive.play();
        regular.play();
    }
    constexpr int kStep = 2, kHalf = kWidth / kStep;
    Image image = grey(2 * kHalf, kHeight / kStep);
    int left = 0;
    for (const Player* player : {&regular, &adaptive}) {
        paste(image, left, player->image(), kWidth, kHeight, kStep);
        drawText(image, left + 6, image.height - 8,
                 fmt::format("{} maps, rmse {:.4f}", player->maps(), truth.rmse(player->image())),
                 kTextPx, 0.0f, 0.0f, 0.0f);
        left += kHalf;
    }
    writePng("schwaerzler_" + c.name + ".png", image);
    state.counters["rmse"] = truth.rmse(adaptive.image());
    state.counters["rmse_regular"] = truth.rmse(regular.image());
}

/// Draws the part of the tree that `text` goes on with (LightTree::preorder) into the square of
/// `side` pixels at (x, y).
void drawTree(Image& image, const char*& text, int x, int y, int side) {
    if (*text++ == '+') {
        const int half = side / 2;
        for (int i = 0; i < 4; ++i)
            drawTree(image, text, x + (i & 1) * half, y + (i >> 1) * half, half);
        return;
    }
    fill(image, x, y, x + side, y + 1, 0.3f, 0.3f, 0.3f);
    fill(image, x, y + side, x + side + 1, y + side + 1, 0.3f, 0.3f, 0.3f);
    fill(image, x, y, x + 1, y + side, 0.3f, 0.3f, 0.3f);
    fill(image, x + side, y, x + side + 1, y + side, 0.3f, 0.3f, 0.3f);
    for (const int cornerX : {x, x + side})
        for (const int cornerY : {y, y + side})
            fill(image, cornerX - 3, cornerY - 3, cornerX + 4, cornerY + 4, 0.8f, 0.1f, 0.05f);
}

/// The scene's own view, the same with a narrow lens, and one turned by a quarter around the
/// scene's centre.
void moveCamera(Camera& camera, int view) {
    if (view == 1) camera.fovYRad *= 0.25;
    if (view != 2) return;
    const auto turned = [](glm::dvec3 v) { return glm::dvec3(v.z, v.y, -v.x); };
    camera.position = turned(camera.position);
    camera.right = turned(camera.right);
    camera.up = turned(camera.up);
    camera.back = turned(camera.back);
}

void trees(benchmark::State& state) {
    needContext();
    constexpr int kPixels = 512, kStep = 2, kSide = kPixels / kStep, kMargin = 16;
    Image image = grey(3 * kSide, 2 * kSide);
    for (auto _ : state)
        for (int view = 0; view < 3; ++view) {
            const Stage stage("spinner", kPixels, kPixels, {},
                              [view](Camera& camera) { moveCamera(camera, view); });
            Player player(
                stage, "adaptive_light_sampled",
                {{"epsilon", "0.13"}, {"centre_test", "false"}, {"criterion", "compared_pixels"}});
            player.play();
            paste(image, view * kSide, player.image(), kPixels, kPixels, kStep);
            const std::string message = player.message();
            const std::string tree = message.substr(message.rfind(' ') + 1);
            const char* text = tree.c_str();
            drawTree(image, text, view * kSide + kMargin, kSide + kMargin, kSide - 2 * kMargin);
            state.counters["maps" + std::to_string(view)] = player.maps();
        }
    writePng("light_trees.png", image);
}

const auto registered = [] {
    for (const Case& c : paperCases())
        if (c.maps < c.regularMaps)
            benchmark::RegisterBenchmark(("adaptive_figures/" + c.name).c_str(), paperFigure, c)
                ->Iterations(1)
                ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark("adaptive_figures/trees", trees)
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra::bench
