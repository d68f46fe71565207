// Shadow rays on the CPU: n points of the light per pixel, Owen-scrambled Sobol with a digital
// shift of its own for every pixel, through the same tracer as the reference. "Just trace rays" on
// the same curve as everything else: unbiased, noisy, its cost linear in n and independent of the
// light's size.
//
// Tiles of pixels that no triangle can shadow (LitTiles) are 1 without a ray, as rays would say.
// There is no such proof of dark for less than rays, and rays have no bias, no layers and no second
// side that a plan could leave out; for the alpha mask the tracer asks where a ray meets one.

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <array>

#include "core/frame/lit_tiles.hpp"
#include "core/frame/shadow_casters.hpp"
#include "core/sampling/sampling.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class RayTraced : public ShadowMethod {
    IntParameter rays_{this, "rays", 16, 1, 65536, "", "shadow rays per pixel"};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"rays", "1"}},
                {{"rays", "4"}},
                {{"rays", "16"}},
                {{"rays", "64"}},
                {{"rays", "256"}}};
    }

    void prepare(const Scene&, const Plan&) override {
        points_.clear();
        for (int i = 0; i < rays_; ++i)
            points_.push_back(owenSobol(static_cast<std::uint32_t>(i), kScramble));
    }

    void build(const Frame& frame, const Plan& plan) override {
        skips_ = !plan.everyPixel && isEarned(frame, plan);
        if (!skips_) return;
        tiles_.build(frame, shadowCasters(frame, {.wholeLight = plan.has(Effect::penumbra)}));
        findTiles(frame, plan);
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        const int width = frame.width(), height = frame.height();
        blocked_.assign(frame.gbuffer.size(), 0);
        // Light space may have stayed as it was while the camera moved.
        if (skips_ && !tiles_.isFor(frame.camera)) findTiles(frame, plan);
        // Without a penumbra to simulate one ray to the light's centre tells all.
        const bool extent = plan.has(Effect::penumbra);
        const auto count = static_cast<float>(extent ? points_.size() : 1);
        // Small tiles keep the rays of one stream close together, which the traversal rewards.
        constexpr int kTile = 8;
        tbb::parallel_for(tbb::blocked_range2d<int>(0, height, kTile, 0, width, kTile),
                          [&](const auto& tile) { traceTile(frame, extent, tile); });
        visibility_.resize(frame.gbuffer.size());
        for (std::size_t i = 0; i < visibility_.size(); ++i)
            visibility_[i] = frame.gbuffer.mask[i] == PixelClass::facingAway
                                 ? 0.0f
                                 : 1.0f - static_cast<float>(blocked_[i]) / count;
        target.upload(visibility_);
    }

    void forgetCamera() override { tiles_.forgetCamera(); }

  private:
    static constexpr std::uint32_t kScramble = 0x5eed1e55u;
    static constexpr double kFindingRays = 4.0;

    /// Whether rays cost more than to prove that they are free: a triangle's place in the tree is
    /// worth about three rays, and a third of the rays may be spared.
    bool isEarned(const Frame& frame, const Plan& plan) const {
        constexpr double kRaysPerTriangle = 10.0;
        const double rays = plan.has(Effect::penumbra) ? static_cast<double>(points_.size()) : 1.0;
        // Finding the tiles costs about four rays per pixel besides.
        return (rays - kFindingRays) * static_cast<double>(frame.gbuffer.size()) >
               kRaysPerTriangle * static_cast<double>(frame.geometry->triangleCount());
    }

    void findTiles(const Frame& frame, const Plan& plan) {
        const glm::dvec2 half(frame.light.halfU, frame.light.halfV);
        tiles_.find(frame, plan.has(Effect::penumbra) ? half : glm::dvec2(0.0), glm::dvec2(0.0));
    }

    void traceTile(const Frame& frame, bool extent, const tbb::blocked_range2d<int>& tile) {
        const AreaLight& light = frame.light;
        const glm::vec3 corner(extent ? light.at(0, 0) : light.centre);
        const glm::vec3 edgeU(extent ? 2.0 * light.halfU * light.axisU : glm::dvec3(0.0));
        const glm::vec3 edgeV(extent ? 2.0 * light.halfV * light.axisV : glm::dvec3(0.0));
        const std::size_t count = extent ? points_.size() : 1;
        Tracer::Stream stream(frame.tracer);
        std::array<std::size_t, Tracer::kStreamSize> owner;
        const auto flush = [&] {
            stream.trace();
            for (std::size_t k = 0; k < stream.size(); ++k) blocked_[owner[k]] += stream.blocked(k);
            stream.clear();
        };
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
            for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
                const auto pixel = static_cast<std::uint32_t>(y * frame.width() + x);
                const PixelClass pixelClass = frame.gbuffer.mask[pixel];
                if (!isAsked(pixelClass)) continue;
                if (skips_ && tiles_.isLit(x / LitTiles::kSide, y / LitTiles::kSide)) continue;
                const glm::vec3 origin = frame.tracer.shadowOrigin(
                    frame.gbuffer.position[pixel], frame.gbuffer.geometricNormal[pixel]);
                const std::uint32_t shiftX = hash(pixel, frame.seed, 0u);
                const std::uint32_t shiftY = hash(pixel, frame.seed, 1u);
                for (std::size_t k = 0; k < count; ++k) {
                    const float s = toUnitFloat(points_[k].x ^ shiftX);
                    const float t = toUnitFloat(points_[k].y ^ shiftY);
                    owner[stream.size()] = pixel;
                    stream.add(origin, corner + s * edgeU + t * edgeV);
                    if (stream.full()) flush();
                }
            }
        flush();
    }

    LitTiles tiles_;
    bool skips_ = false;
    std::vector<std::uint32_t> blocked_;  // rays per pixel
    std::vector<SobolPoint> points_;
    std::vector<float> visibility_;
};

const Register<RayTraced> entry{"ray_traced", "Ray-traced shadows on the CPU",
                                "Cook, Porter, Carpenter 1984"};

}  // namespace
}  // namespace penumbra
