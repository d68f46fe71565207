// Light-sampled shadow maps: a hard map from each of n points of the light, their comparisons
// averaged (Heckbert, Herf 1997, "Simulating Soft Shadows with Graphics Hardware", CMU-CS-97-104;
// Schwaerzler 2009, eq. 2; METHODS.md 11). The frusta are translates of each other with parallel
// image planes, so that a receiver has the same depth in all maps and a comparison costs little
// more than its fetch; it converges to the truth, occluder fusion and all, at n times the cost of a
// hard shadow. It fails by banding: a penumbra shows n edges (sqrt n under a straight caster's edge
// when the points lie in rows) spaced by its width over as many; and every map's bias moves its own
// contact, which sums to a soft peter-panning.
//
// A plan saves what can change no comparison: triangles that no map shows at a receiver (closed
// bodies have one side only; thin_casters are drawn from both), parts that cast nothing, the bias
// where self_shadow is off, and the lookups of tiles that nothing can shadow (LitTiles). Dark tiles
// are looked up: that a map from every point is blocked cannot be told for less than looking.
// Nothing is saved on layered_casters, for a map keeps one layer however many there are.

#include <algorithm>
#include <cmath>

#include "core/gl/program.hpp"
#include "core/passes/accumulation_buffer.hpp"
#include "core/passes/light_maps.hpp"
#include "core/passes/pixel_classes.hpp"
#include "core/sampling/sampling.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class LightSampled : public ShadowMethod {
    IntParameter samples_{
        this,
        "samples",
        16,
        1,
        1024,
        "",
        "points of the light, a map each; patterns in rows take the most that fit "
        "rows and columns in the light's proportions"};
    ChoiceParameter pattern_{this,
                             "pattern",
                             {"grid", "lattice", "jittered", "owen"},
                             "points at the centres of equal cells; from corner to corner of the "
                             "light; at random within "
                             "the cells; or Owen-scrambled Sobol points"};
    ChoiceParameter weights_{
        this,
        "weights",
        {"equal", "trapezoid"},
        "trapezoid counts a lattice's corners 1/4 and edges 1/2, for the part of the light they "
        "stand for; other patterns have no rim"};
    ChoiceParameter accumulation_{
        this,
        "accumulation",
        {"array", "buffer"},
        "all maps in one texture array read in one pass (in several, where they fill 256 MiB), or "
        "one map at a time added to a buffer; the image is the same"};
    BoolParameter pcf_{
        this, "pcf", false,
        "four comparisons per map, weighted as the receiver lies between their texels"};
    IntParameter mapSize_{this, "map_size", 512, 16, 16384, "texels", "side of each shadow map"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"samples", "4"}, {"map_size", "256"}},
                {{"samples", "9"}, {"pcf", "true"}},
                {{"samples", "25"}, {"pcf", "true"}},
                {{"samples", "64"}, {"pcf", "true"}},
                {{"samples", "256"}, {"pcf", "true"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        plan_ = plan;
        maps_ = LightMaps(plan, bias_.compared(plan, kernel()), kernel());
        if (!plan.has(Effect::penumbra)) {
            oneMap_ = program({"PASS_ONE_MAP"});
            return;
        }
        all_ = program({"PASS_ALL"});
        add_ = program({"PASS_ADD"});
        resolve_ = program({"PASS_RESOLVE"});
        if (plan.everyPixel) return;
        undecided_ = program({"PASS_ALL", "UNDECIDED_TILES"});
        classes_ = PixelClasses::decided();
    }

    void build(const Frame& frame, const Plan& plan) override {
        hard_ = !plan.has(Effect::penumbra) || frame.light.isPoint();
        points_ = hard_ ? std::vector<LightSample>(1) : points(frame);
        maps_.fit(frame, mapSize_, !hard_);
        perPass_ = accumulation_.is("array") ? maps_.capacity() : 1;
        if (points_.size() <= perPass_) maps_.render(frame, points_);
        // Without bias maps may let a surface shadow itself, which no geometry tells.
        const bool clear = bias_ > 0.0 || !plan.has(Effect::self_shadow);
        skips_ = !hard_ && !plan.everyPixel && clear && points_.size() <= perPass_ &&
                 maps_.tileCount() == 1;
        if (!skips_) return;
        tiles_.build(frame, maps_.casters());
        classify(frame);
    }

    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        if (points_.size() > perPass_) return accumulate(frame, target);
        const gl::DebugGroup group("light_sampled: compare");
        if (skips_) {
            // Light space may have stayed as it was while the camera moved.
            if (!tiles_.isFor(frame.camera)) classify(frame);
            drawn(undecided_);
            classes_.shade(undecided_, frame);
            return target.draw(classes_.answers(), frame.gbufferTextures);
        }
        drawn(hard_ ? oneMap_ : all_);
        target.draw(hard_ ? oneMap_ : all_, frame.gbufferTextures);
    }

    void forgetCamera() override { tiles_.forgetCamera(); }

    WorkCounters counters() const override {
        const int maps = static_cast<int>(points_.size()) * maps_.tileCount();
        const double texels = static_cast<double>(mapSize_) * mapSize_;
        return {maps, maps * texels, maps_.mebibytes() + sum_.mebibytes() + classes_.mebibytes(),
                ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow maps of the samples, near / z", &maps_.texture()},
                {"sum over the samples", &sum_.sum()}};
    }

  private:
    gl::Program program(std::vector<std::string> defines) const {
        if (pcf_) defines.emplace_back("LIGHT_MAPS_PCF");
        return gl::Program::graphics("light_sampled.glsl", MapBias::defines(plan_, defines));
    }

    int kernel() const { return pcf_ ? 2 : 1; }

    void drawn(const gl::Program& program) const {
        program.use();
        maps_.bind(program);
        bias_.set(program, plan_);
    }

    void classify(const Frame& frame) {
        tiles_.find(frame, maps_.half(), maps_.reachTangent(kernel()));
        classes_.decide(frame, tiles_);
    }

    /// More maps than one array holds: rendered into the same layers and added up in turn.
    void accumulate(const Frame& frame, const VisibilityTarget& target) {
        const gl::DebugGroup group("light_sampled: accumulate");
        if (sum_.width() != target.width() || sum_.height() != target.height())
            sum_ = AccumulationBuffer(target.width(), target.height());
        sum_.clear();
        float total = 0.0f;
        const std::span<const LightSample> all(points_);
        for (std::size_t first = 0; first < all.size(); first += perPass_) {
            const auto some = all.subspan(first, std::min(perPass_, all.size() - first));
            for (const LightSample& sample : some) total += sample.weight;
            maps_.render(frame, some);
            drawn(add_);
            sum_.add(add_, frame.gbufferTextures);
        }
        resolve_.use();
        resolve_.set("totalWeight", total);
        sum_.sum().bind(0);
        target.draw(resolve_, frame.gbufferTextures);
    }

    std::vector<LightSample> points(const Frame& frame) const {
        const glm::dvec2 halfM(frame.light.halfU, frame.light.halfV);
        std::vector<LightSample> points;
        const auto add = [&](glm::dvec2 st, float weight) {
            points.push_back({(2.0 * st - 1.0) * halfM, weight});
        };
        if (pattern_.is("owen")) {
            for (int i = 0; i < samples_; ++i)
                add(owenSobol(static_cast<std::uint32_t>(i), frame.seed).unit(), 1.0f);
            return points;
        }
        const glm::ivec2 counts = columnsAndRows(halfM);
        for (int j = 0; j < counts.y; ++j)
            for (int i = 0; i < counts.x; ++i) {
                const glm::ivec2 cell(i, j);
                glm::dvec2 st = (glm::dvec2(cell) + 0.5) / glm::dvec2(counts);
                float weight = 1.0f;
                for (int axis = 0; axis < 2; ++axis) {
                    if (pattern_.is("jittered"))
                        st[axis] = (cell[axis] + jitter(frame.seed, cell, axis)) / counts[axis];
                    if (!pattern_.is("lattice") || counts[axis] == 1) continue;
                    st[axis] = static_cast<double>(cell[axis]) / (counts[axis] - 1);
                    const bool rim = cell[axis] == 0 || cell[axis] == counts[axis] - 1;
                    // Whole numbers, so that sums are exact.
                    if (weights_.is("trapezoid") && !rim) weight *= 2.0f;
                }
                add(st, weight);
            }
        return points;
    }

    /// As many cells as `samples` allows, as square as the light's proportions let them be.
    glm::ivec2 columnsAndRows(glm::dvec2 halfM) const {
        const int wide = halfM.x >= halfM.y ? 0 : 1, narrow = 1 - wide;
        constexpr double kRounding = 1e-9;  // 16 samples of a square are 4 rows
        glm::ivec2 counts;
        counts[narrow] = std::max(
            1, static_cast<int>(std::sqrt(samples_ * halfM[narrow] / halfM[wide]) + kRounding));
        counts[wide] = samples_ / counts[narrow];
        return counts;
    }

    static double jitter(std::uint32_t seed, const glm::ivec2& cell, int axis) {
        return static_cast<double>(
            toUnitFloat(hash(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                             static_cast<std::uint32_t>(axis), seed)));
    }

    LightMaps maps_;
    AccumulationBuffer sum_;
    LitTiles tiles_;
    PixelClasses classes_;
    gl::Program oneMap_, all_, add_, resolve_, undecided_;
    std::vector<LightSample> points_;
    std::size_t perPass_ = 1;
    Plan plan_;
    bool hard_ = false, skips_ = false;
};

const Register<LightSampled> entry{"light_sampled", "Light-sampled shadow maps",
                                   "Heckbert, Herf 1997"};

}  // namespace
}  // namespace penumbra
