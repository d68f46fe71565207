// The window under a real display (Xvfb), driven by synthetic input.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <cstdlib>
#include <set>

#include "core/gl/window.hpp"
#include "core/image/image.hpp"
#include "harness/viewer/camera_control.hpp"
#include "harness/viewer/gui_renderer.hpp"
#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/save_view.hpp"
#include "harness/viewer/viewer_app.hpp"
#include "tests/support/fake_methods.hpp"
#include "tests/support/run_program.hpp"
#include "tests/viewer/viewer_fixture.hpp"

namespace penumbra {
namespace {

bool hasDisplay() {
    return std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
}

/// A window with the viewer in it, and the hand that moves its mouse.
class Opened {
  public:
    Opened(const ViewOptions& options, int width, int height)
        : window_({"Penumbra test", width, height, /*visible=*/true}) {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        gui::setStyle(1.0f, 1.0f);
        renderer_.emplace();
        session_.emplace(options);
        app_.emplace(*session_, options, 1.0f);
        resize(width, height);
    }
    ~Opened() {
        app_.reset();
        session_.reset();
        renderer_.reset();
        ImGui::DestroyContext();
    }

    ViewSession& session() { return *session_; }
    ViewerApp& app() { return *app_; }
    ViewerState& state() { return app_->state(); }
    ImageView::Pane pane() const { return app_->image().pane(0); }

    void resize(int width, int height) {
        glfwSetWindowSize(window_.handle(), std::max(1, width), std::max(1, height));
        glfwPollEvents();
        ImGui::GetIO().DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
    }
    /// One frame, as the window's loop draws it.
    bool step() {
        ImGui::GetIO().DeltaTime = 1.0f / 60.0f;
        ImGui::NewFrame();
        const bool more = app_->frame(1.0 / 60.0);
        ImGui::Render();
        renderer_->draw(*ImGui::GetDrawData(), 0);
        gl::checkErrors("window test");
        return more;
    }
    void settle() {
        while (step()) {
        }
        step();
    }
    void mouseTo(float x, float y) {
        ImGui::GetIO().MousePos = {x, y};
        step();
    }
    void button(bool down) {
        ImGui::GetIO().MouseDown[0] = down;
        step();
    }
    void drag(ImVec2 from, ImVec2 to) {
        mouseTo(from.x, from.y);
        button(true);
        mouseTo(0.5f * (from.x + to.x), 0.5f * (from.y + to.y));
        mouseTo(to.x, to.y);
        button(false);
    }
    std::vector<std::uint8_t> pixels() {
        step();
        const ImVec2 size = ImGui::GetIO().DisplaySize;
        return readFramebuffer(0, static_cast<int>(size.x), static_cast<int>(size.y));
    }

  private:
    gl::Window window_;
    std::optional<GuiRenderer> renderer_;
    std::optional<ViewSession> session_;
    std::optional<ViewerApp> app_;
};

class Window : public ::testing::Test {
  protected:
    void SetUp() override {
        if (!hasDisplay()) GTEST_SKIP() << "no display: install xvfb, or set DISPLAY";
    }
    ViewOptions options(std::vector<std::string> methods,
                        const std::string& scene = "half_plane") const {
        return test::smallView(scene, std::move(methods), folder.path() / "cache");
    }
    testing::TempFolder folder;
};

TEST_F(Window, ShowsEveryMethod) {
    Opened open(options({"hard"}), 900, 600);
    for (const MethodInfo& info : methodRegistry()) {
        if (info.id.starts_with("fake_")) continue;
        open.session().setMethod(0, info.id);
        open.settle();
        EXPECT_EQ(open.session().method(0)->status(), "ok")
            << info.id << ": " << open.session().method(0)->message();
        // A shaded picture, not one flat colour.
        const auto bytes = open.pixels();
        const ImageView::Pane pane = open.pane();
        std::set<int> reds;
        for (auto y = static_cast<std::size_t>(pane.lo.y + 0.2f * pane.height()); y < pane.hi.y;
             ++y)
            for (auto x = static_cast<std::size_t>(pane.lo.x); x < pane.hi.x; ++x)
                reds.insert(bytes[3 * (900 * y + x)]);
        EXPECT_GT(reds.size(), 20u) << info.id;
    }
}

TEST_F(Window, TheSplitLineIsDragged) {
    ViewOptions o = options({"hard", "fake_constant"});
    o.display = Display::split;
    Opened open(o, 900, 600);
    open.state().handles = false;
    open.settle();
    const ImageView::Pane pane = open.pane();
    const Camera camera = open.session().camera();
    const auto x = [&](float share) { return pane.lo.x + share * pane.width(); };
    const float y = pane.hi.y - 20.0f;
    const auto before = open.pixels();
    open.drag({x(0.5f), y}, {x(0.2f), y});
    EXPECT_NEAR(open.state().split, 0.2f, 0.01f);  // a pixel of some 250
    EXPECT_EQ(open.session().camera(), camera) << "the hand had the line, not the camera";
    const auto after = open.pixels();
    int changed = 0, all = 0;
    for (auto py = static_cast<std::size_t>(pane.lo.y); py < pane.hi.y; ++py)
        for (auto px = static_cast<std::size_t>(x(0.25f)); px < x(0.45f); ++px, ++all)
            changed += before[3 * (900 * py + px)] != after[3 * (900 * py + px)];
    EXPECT_GT(changed, all / 4) << "B is to be seen where A was";
    // Past the image's edge it stays at the edge.
    open.drag({x(0.2f), y}, {x(-0.4f), y});
    EXPECT_EQ(open.state().split, 0.0f);
}

TEST_F(Window, DraggingOrbitsAndTheHandlesMoveTheLight) {
    Opened open(options({"hard"}), 900, 600);
    open.settle();
    ImageView::Pane pane = open.pane();
    const Camera camera = open.session().camera();
    open.drag({pane.lo.x + 30.0f, pane.hi.y - 30.0f}, {pane.lo.x + 90.0f, pane.hi.y - 40.0f});
    EXPECT_TRUE(open.session().cameraEdited());
    EXPECT_NE(open.session().camera().position, camera.position);
    EXPECT_FALSE(open.session().lightEdited());
    // Back off until the light is in view, and take its centre.
    Bounds bounds = boundsOf(open.session().state().geometry->positions);
    for (const glm::dvec3& corner : open.session().light().corners()) bounds.add(corner);
    open.session().setCamera(
        backedOff(open.session().camera(), bounds.centre(), bounds.radius(), 1.0));
    open.settle();
    const Camera off = open.session().camera();
    const auto seen = projected(off, open.session().light().centre, 64, 64);
    ASSERT_TRUE(seen);
    pane = open.pane();
    const ImVec2 at(pane.lo.x + static_cast<float>(seen->x) / 64.0f * pane.width(),
                    pane.lo.y + static_cast<float>(seen->y) / 64.0f * pane.height());
    const glm::dvec3 centre = open.session().light().centre;
    open.drag(at, {at.x + 30.0f, at.y});
    EXPECT_TRUE(open.session().lightEdited());
    EXPECT_EQ(open.session().camera(), off);
    const glm::dvec3 by = open.session().light().centre - centre;
    EXPECT_NEAR(glm::dot(by, off.right) / glm::length(by), 1.0, 1e-9)
        << "to the right, as the hand";
}

TEST_F(Window, EverySizeIsDrawn) {
    Opened open(options({"hard"}), 900, 600);
    open.settle();
    for (const auto& [width, height] :
         {std::pair(1200, 700), std::pair(300, 800), std::pair(64, 48), std::pair(1, 1),
          std::pair(0, 0), std::pair(900, 0), std::pair(700, 500)}) {
        open.resize(width, height);
        open.step();
        open.step();
    }
    EXPECT_GT(open.pane().width(), 100.0f);
    // An image that follows the window.
    open.state().fit = true;
    open.settle();
    EXPECT_NEAR(open.session().width(), open.pane().width(), 1.0);
    open.resize(500, 400);
    open.settle();
    EXPECT_NEAR(open.session().width(), open.pane().width(), 1.0);
    EXPECT_LT(open.session().width(), 250);
}

TEST_F(Window, DenseDisplaysHaveMorePixelsThanUnits) {
    Opened open(options({"hard"}), 800, 600);
    ImGui::GetIO().DisplaySize = {400.0f, 300.0f};
    ImGui::GetIO().DisplayFramebufferScale = {2.0f, 2.0f};
    open.settle();
    const auto pixels = readFramebuffer(0, 800, 600);
    int drawn = 0;  // to the right of and below what 400 x 300 pixels would reach
    for (std::size_t y = 310; y < 600; ++y)
        for (std::size_t x = 410; x < 800; ++x) drawn += pixels[3 * (y * 800 + x)] != pixels[0];
    EXPECT_GT(drawn, 1000);
    ImGui::GetIO().DisplayFramebufferScale = {1.0f, 1.0f};
}

TEST_F(Window, BadInputIsSaidAndTheWindowLivesOn) {
    Opened open(options({"hard"}), 900, 600);
    open.settle();
    open.state().open(folder.write("broken.glb", "no glTF at all").string());
    EXPECT_TRUE(open.state().noticeIsError);
    EXPECT_NE(open.state().notice.find("broken.glb"), std::string::npos) << open.state().notice;
    open.settle();
    EXPECT_EQ(open.session().scene().id, "half_plane");
    open.session().setMethod(0, "fake_throws_in_prepare");
    open.settle();
    EXPECT_EQ(open.session().method(0)->status(), "failed");
    open.state().open("fence");
    EXPECT_FALSE(open.state().noticeIsError) << open.state().notice;
    open.session().setMethod(0, "pcf");
    open.settle();
    EXPECT_EQ(open.session().method(0)->status(), "ok");
}

TEST_F(Window, EveryDisplayAndPanelIsDrawnWhileTheTracksPlay) {
    Opened open(options({"adaptive_light_sampled", "vsm"}, "fence"), 1000, 900);
    for (const DisplayName& name : kDisplays)
        for (const Against against : {Against::method, Against::reference}) {
            open.state().display = name.display;
            open.state().against = against;
            open.step();
            open.step();
        }
    open.state().playing = true;
    const double before = open.session().timeS();
    for (int i = 0; i < 8; ++i) open.step();  // 0.13 s: some of 1/30 s
    EXPECT_GT(open.session().timeS(), before);
    open.state().playing = false;
    open.settle();
    EXPECT_FALSE(open.session().method(0)->textures().empty());
}

TEST_F(Window, ASavedViewIsTheSameImageInBatch) {
    std::vector<float> shown;
    const auto script = folder.path() / "saved.toml";
    {
        Opened open(options({"pcss"}, "fence"), 900, 600);
        open.settle();
        const ImageView::Pane pane = open.pane();
        open.state().handles = false;
        open.drag({pane.lo.x + 30.0f, pane.hi.y - 30.0f}, {pane.lo.x + 70.0f, pane.hi.y - 50.0f});
        open.session().showFrame(open.session().timeline().listed[1]);
        open.settle();
        ASSERT_TRUE(open.session().cameraEdited());
        saveView(open.session(), script);
        shown = open.session().method(0)->visibility();
    }
    const auto out = folder.path() / "run";
    const test::Finished batch =
        test::penumbra({"compare", "--scene", script.string(), "--method", "pcss", "--size",
                        "64x64", "--repeats", "1", "--reference-se", "0.05", "--cache",
                        (folder.path() / "cache").string(), "--out", out.string()});
    ASSERT_EQ(batch.exitCode, 0) << batch.err;
    const auto image =
        readImage(out / "images" / "saved" / "0000" / "pcss.exr").channel("visibility");
    ASSERT_EQ(image.size(), shown.size());
    for (std::size_t i = 0; i < shown.size(); ++i) ASSERT_NEAR(shown[i], image[i], 1.0 / 255) << i;
}

TEST_F(Window, TheCommandWritesAScreenshotAndEnds) {
    const auto file = folder.path() / "window.png";
    const test::Finished view =
        test::penumbra({"view", "--scene", "half_plane", "--method", "hard", "--size", "64x64",
                        "--window", "640x400", "--screenshot", file.string()});
    EXPECT_EQ(view.exitCode, 0) << view.err;
    const Image image = readImage(file);
    EXPECT_EQ(image.width, 640);
    EXPECT_EQ(image.height, 400);
}

TEST(Command, SaysWhatIsMissingWithoutADisplay) {
    const test::Finished view =
        test::penumbra({"view", "--scene", "half_plane"}, {"DISPLAY=", "WAYLAND_DISPLAY="});
    EXPECT_EQ(view.exitCode, 2);
    EXPECT_EQ(test::lines(view.err).size(), 1u) << view.err;
    EXPECT_NE(view.err.find("no display"), std::string::npos) << view.err;
    EXPECT_NE(view.err.find("xvfb-run"), std::string::npos) << view.err;
}

}  // namespace
}  // namespace penumbra
