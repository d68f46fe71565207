// Adaptive light sampling: hard maps from the light's corners are compared at the camera's pixels,
// and where too many pixels differ that part of the light is split in four (a linear light's in
// two), which adds maps in between; the maps reached are weighed and averaged (Schwaerzler 2009,
// "Real-Time Soft Shadows with Adaptive Light Source Sampling"; METHODS.md 12). Small penumbrae get
// few maps, great ones all the lattice. It fails where no corner tells what lies between: casters
// that hide none of them, and in the paper's own form those that hide two opposite ones alike or
// shadows of few pixels; and what it saves in maps it pays in comparisons, unless these share the
// evaluation's fetches or are made at few pixels.
//
// Of a plan it saves what light_sampled does: triangles, parts and lit tiles.
// layered_casters saves nothing, for a map keeps one layer however many there are, nor does
// thin_casters beyond the second sides that closed bodies do without; dark tiles are looked up, for
// that every map is blocked cannot be told for less.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/passes/accumulation_buffer.hpp"
#include "core/passes/light_maps.hpp"
#include "core/passes/map_comparison.hpp"
#include "core/passes/pixel_classes.hpp"
#include "core/sampling/light_refinement.hpp"
#include "core/sampling/light_tree_picture.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class AdaptiveLightSampled : public ShadowMethod {
    FloatParameter epsilon_{this,
                            "epsilon",
                            0.4,
                            0.0,
                            1e6,
                            "",
                            "a part of the light is split unless what the criterion makes of the "
                            "pixels that differ between its maps is less; 0 splits all"};
    IntParameter maxDepth_{this, "max_depth", 3, 0, 7, "", "how often the light is split"};
    IntParameter maxMaps_{this,
                          "max_maps",
                          81,
                          4,
                          256,
                          "",
                          "where they do not suffice, parts that differ most are split first"};
    ChoiceParameter compare_{
        this,
        "compare",
        {"tight", "absolute", "relative", "symmetric"},
        "what of two maps is compared: shadow tests; depths, to gamma times that of the farthest "
        "receiver (eq. 3), to gamma of the second (eq. 7), or to gamma of the greater"};
    FloatParameter gamma_{this, "gamma", 0.01, 0.0, 1e6, "", "how much equal depths may differ"};
    ChoiceParameter criterion_{
        this,
        "criterion",
        {"visibility", "worst_tile", "compared_pixels", "map_texels"},
        "the share of pixels that differ: in the tile where it is greatest, its root times the "
        "part's share of the light, which is the rms error the part may make there, or itself; of "
        "all pixels compared; or, as in the paper's eq. 4, of the map's texels"};
    IntParameter tile_{this, "tile", 64, 8, 4096, "pixels", "side of a tile"};
    ChoiceParameter pairs_{this,
                           "pairs",
                           {"all", "diagonals"},
                           "all four corners are compared with each other, or, as in the paper, "
                           "opposite ones"};
    IntParameter rimDepth_{
        this,
        "rim_depth",
        2,
        -1,
        7,
        "",
        "maps are from points drawn in from the light's rim, so that those of a tree "
        "split this often everywhere stand amid equal cells; -1: from its very corners "
        "on, as in the paper"};
    BoolParameter centreTest_{this, "centre_test", true,
                              "each part of the light has a map amid it, too, that is compared "
                              "with its corners' and counts half of the part"};
    ChoiceParameter space_{
        this,
        "space",
        {"camera", "light"},
        "maps are compared at the camera's pixels, or at what the light's centre sees"};
    ChoiceParameter weights_{
        this,
        "weights",
        {"leaf_area", "local_depth", "equal"},
        "what a map counts: its share of its parts' areas, the paper's eqs 5 and 6, or all alike"};
    ChoiceParameter countBy_{
        this,
        "count_by",
        {"bits", "queries"},
        "shadow tests are kept as bits, so that a map is looked up once for all comparisons (tight "
        "ones in the camera's space only), or each comparison is an occlusion query"};
    IntParameter stride_{
        this, "stride", 8, 1, 64, "pixels", "of so many pixels in a row or column one is compared"};
    ChoiceParameter evaluation_{this,
                                "evaluation",
                                {"array", "buffer", "bits"},
                                "all maps are read in one pass, or added to a buffer one by one, "
                                "or visibility follows from "
                                "the comparisons' bits (where all pixels have them, else array)"};
    BoolParameter skipDecided_{
        this, "skip_decided", true,
        "tiles of 4 x 4 pixels that no triangle can shadow, from any point of the light, are lit: "
        "neither compared (in the camera's space) nor looked up (evaluation in one array); not "
        "where "
        "receivers are far aside and a map has five tiles"};
    BoolParameter reuse_{this, "reuse", false,
                         "refinement starts where the previous frame's ended, less what that could "
                         "have done without; the image then depends on the frames before"};
    ChoiceParameter pcf_{this,
                         "pcf",
                         {"off", "2x2", "3x3", "5x5"},
                         "comparisons per map, weighted as the receiver lies between their texels"};
    IntParameter mapSize_{this, "map_size", 512, 16, 16384, "texels", "side of each shadow map"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"epsilon", "0.5"}, {"map_size", "256"}, {"centre_test", "false"}},
                {{"epsilon", "0.2"}},
                {{"epsilon", "0.08"}, {"rim_depth", "3"}, {"pcf", "2x2"}},
                {{"epsilon", "0.04"}, {"rim_depth", "3"}, {"pcf", "2x2"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        maps_ = LightMaps(plan, mapParts(plan), kernel());
        plan_ = plan;
        if (!plan.has(Effect::penumbra)) {
            oneMap_ = evaluation("light_sampled.glsl", {"PASS_ONE_MAP"});
            return;
        }
        all_ = evaluation("light_sampled.glsl", {"PASS_ALL"});
        if (skips()) {
            classes_ = PixelClasses::decided();
            undecided_ = evaluation("light_sampled.glsl", {"PASS_ALL", "UNDECIDED_TILES"});
        }
        if (bits()) {
            mark_ = comparison({"PASS_MARK_BITS"});
        } else {
            differ_ = comparison(comparisonDefines());
            if (collects()) {
                collect_ = comparison({"PASS_COLLECT"});
                std::vector<std::string> collected = comparisonDefines();
                collected.emplace_back("COLLECTED");
                differCollected_ = comparison(collected);
            }
            if (space_.is("light")) centreMap_ = DepthPass(plan);
        }
        if (shadedFromBits())
            shadeBits_ = evaluation("adaptive_light_sampled.glsl", {"PASS_SHADE_BITS"});
        if (!evaluation_.is("buffer")) return;
        add_ = evaluation("light_sampled.glsl", {"PASS_ADD"});
        resolve_ = evaluation("light_sampled.glsl", {"PASS_RESOLVE"});
    }

    void build(const Frame& frame, const Plan& plan) override {
        hard_ = !plan.has(Effect::penumbra) || frame.light.isPoint();
        builtFor_ = frame.camera;
        maps_.fit(frame, mapSize_, !hard_);
        if (hard_) return maps_.render(frame, std::vector<LightSample>(1));
        const gl::DebugGroup group("adaptive_light_sampled: refine");
        findLitTiles(frame);
        refine(frame);
        maps_.setWeights(finalWeights());
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        // Light space may have stayed as it was while the camera, which refinement depends on,
        // moved.
        const bool anew = !hard_ && space_.is("camera") && builtFor_ != frame.camera;
        if (anew) build(frame, plan);
        shadeMaps_ = anew ? mapCount() : 0;
        if (!hard_ && evaluation_.is("buffer")) return accumulate(frame, target);
        const gl::DebugGroup group("adaptive_light_sampled: evaluate");
        const bool fromBits = !hard_ && shadedFromBits();
        const bool undecided = !hard_ && tilesFound_;
        const gl::Program& program = hard_       ? oneMap_
                                     : fromBits  ? shadeBits_
                                     : undecided ? undecided_
                                                 : all_;
        drawn(program);
        if (fromBits) bits_.bind();
        if (!undecided) return target.draw(program, frame.gbufferTextures);
        classes_.shade(program, frame);
        target.draw(classes_.answers(), frame.gbufferTextures);
    }

    void forgetCamera() override { builtFor_.reset(); }

    WorkCounters counters() const override {
        const int maps = mapCount();
        const double texels = static_cast<double>(mapSize_) * mapSize_;
        return {maps, maps * texels,
                maps_.mebibytes() + centreMap_.map().mebibytes() + classes_.mebibytes() +
                    sum_.mebibytes() + bits_.mebibytes() + collected_.mebibytes(),
                hard_ ? "" : refinement_.summary(), shadeMaps_};
    }
    std::vector<NamedTexture> textures() const override {
        std::vector<NamedTexture> list;
        if (!hard_)
            list.push_back({"tree over the light: depth of its leaves", nullptr,
                            std::make_shared<const Image>(leafDepths(refinement_.tree(), 256))});
        list.push_back({"shadow maps of the samples, near / z", &maps_.texture()});
        list.push_back({"map of the light's centre", &centreMap_.map()});
        list.push_back({"sum over the samples", &sum_.sum()});
        return list;
    }

  private:
    int mapCount() const { return maps_.count() * maps_.tileCount() + centreMap_.map().layers(); }

    /// Comparisons of depths see what no shadow test does.
    MapParts mapParts(const Plan& plan) const {
        return compare_.is("tight") && !space_.is("light") ? bias_.compared(plan, kernel())
                                                           : MapBias::filtered(plan);
    }

    bool bits() const { return countBy_.is("bits") && compare_.is("tight") && space_.is("camera"); }
    bool shadedFromBits() const { return bits() && evaluation_.is("bits") && stride_ == 1; }
    bool skips() const {
        // Without bias maps may let a surface shadow itself, which no geometry tells.
        const bool clear = bias_ > 0.0 || !plan_.has(Effect::self_shadow);
        return !plan_.everyPixel && clear && skipDecided_ && space_.is("camera") &&
               !shadedFromBits();
    }

    void findLitTiles(const Frame& frame) {
        tilesFound_ = skips() && maps_.tileCount() == 1;
        if (!tilesFound_) return;
        tiles_.build(frame, maps_.casters());
        tiles_.find(frame, maps_.half(), maps_.reachTangent(kernel()));
        classes_.decide(frame, tiles_);
    }

    /// Texels across that one map is looked up in.
    int kernel() const { return std::array{1, 2, 3, 5}[static_cast<std::size_t>(pcf_.index())]; }

    /// Whether pixels that may differ are collected once for all queries: where neither the
    /// receiver's plane nor the tile it is in matters.
    bool collects() const { return !compare_.is("tight") && space_.is("camera") && !byTile(); }

    gl::Program comparison(std::vector<std::string> defines) const {
        if (skips()) defines.emplace_back("SKIP_LIT_TILES");
        return gl::Program::graphics("adaptive_light_sampled.glsl",
                                     MapBias::defines(plan_, std::move(defines)));
    }

    gl::Program evaluation(const char* file, std::vector<std::string> defines) const {
        if (pcf_.is("2x2")) defines.emplace_back("LIGHT_MAPS_PCF");
        if (pcf_.is("3x3")) defines.emplace_back("LIGHT_MAPS_KERNEL 3");
        if (pcf_.is("5x5")) defines.emplace_back("LIGHT_MAPS_KERNEL 5");
        return gl::Program::graphics(file, MapBias::defines(plan_, std::move(defines)));
    }

    std::vector<std::string> comparisonDefines() const {
        std::vector<std::string> defines = {
            "PASS_COMPARE", pairs_.is("all") ? "COMPARED_MAPS 4" : "COMPARED_MAPS 2"};
        const char* const kinds[] = {"COMPARE_TIGHT", "COMPARE_ABSOLUTE", "COMPARE_RELATIVE",
                                     "COMPARE_SYMMETRIC"};
        defines.emplace_back(kinds[compare_.index()]);
        if (space_.is("light")) defines.emplace_back("LIGHT_SPACE");
        return defines;
    }

    void drawn(const gl::Program& program) const {
        program.use();
        maps_.bind(program);
        bias_.set(program, plan_);
    }

    using Part = LightRefinement::Part;

    void refine(const Frame& frame) {
        const glm::bvec2 extent(frame.light.halfU > 0.0, frame.light.halfV > 0.0);
        const std::optional<int> rim = rimDepth_ < 0 ? std::nullopt : std::optional<int>(rimDepth_);
        // Four corners are the least that there is, whatever memory they take.
        const auto most = static_cast<int>(std::max<std::size_t>(
            4, std::min(static_cast<std::size_t>(maxMaps_), maps_.capacity())));
        if (space_.is("light")) centreMap_.render(frame, maps_.centre(), mapSize_);
        refinement_.run(LightTree(extent, maxDepth_, rim), {epsilon_, most, centreTest_, reuse_},
                        [&](const LightTree& tree, std::span<Part> parts, int known) {
                            render(frame, tree, known);
                            judge(frame, tree, parts, known);
                        });
    }

    /// Renders the maps of all samples after the first `known`.
    void render(const Frame& frame, const LightTree& tree, int known) {
        const glm::dvec2 halfM(frame.light.halfU, frame.light.halfV);
        std::vector<LightSample> added;
        for (auto i = static_cast<std::size_t>(known); i < tree.sampleCount(); ++i)
            added.push_back({tree.position(i) * halfM, 1.0f});
        if (known == 0)
            maps_.render(frame, added);
        else if (!added.empty())
            maps_.append(frame, added);
    }

    void judge(const Frame& frame, const LightTree& tree, std::span<Part> parts, int known) {
        std::vector<MapComparison> comparisons;
        std::vector<std::size_t> partOf;
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (const MapComparison& comparison : comparisonsOf(parts[i].leaf, pairs_.is("all"))) {
                comparisons.push_back(comparison);
                partOf.push_back(i);
            }
        const TileGrid tiles = tileGrid(frame);
        const std::vector<std::uint64_t> counts = differing(frame, comparisons, tiles, known);
        const double whole = pixelsThatMayDiffer(frame, tiles);
        for (std::size_t i = 0; i < counts.size(); ++i) {
            Part& part = parts[partOf[i / tiles.count()]];
            double error = static_cast<double>(counts[i]) / whole;
            if (criterion_.is("visibility")) error = std::sqrt(error) * tree.area(part.leaf);
            part.error = std::max(part.error, error);
        }
    }

    bool byTile() const { return criterion_.is("visibility") || criterion_.is("worst_tile"); }

    /// Tiles of the pixels compared.
    TileGrid tileGrid(const Frame& frame) const {
        TileGrid tiles{mapSize_, mapSize_, 0};
        if (space_.is("camera")) {
            tiles.width = (frame.width() + stride_ - 1) / stride_;
            tiles.height = (frame.height() + stride_ - 1) / stride_;
        }
        const int longer = std::max(tiles.width, tiles.height);
        const int step = space_.is("camera") ? stride_ : 1;
        tiles.side = byTile() ? std::clamp(tile_ / step, 1, longer) : longer;
        return tiles;
    }

    /// What the count of a comparison and tile is divided by.
    double pixelsThatMayDiffer(const Frame& frame, const TileGrid& tiles) const {
        if (byTile()) return static_cast<double>(tiles.side) * tiles.side;
        const double texels = static_cast<double>(mapSize_) * mapSize_;
        if (space_.is("light")) return texels;
        // Eq. 4 is about all pixels, of which each that is compared stands for several.
        if (criterion_.is("map_texels")) return texels / (stride_ * stride_);
        return std::max(1, receiversAmong(frame.gbuffer, stride_));
    }

    /// Pixels that differ, by comparison and tile; with bits new maps' tests are added to them.
    std::vector<std::uint64_t> differing(const Frame& frame,
                                         const std::vector<MapComparison>& comparisons,
                                         const TileGrid& tiles, int known) {
        const gl::DebugGroup group("adaptive_light_sampled: compare");
        if (bits()) {
            if (!bits_.holds(tiles.width, tiles.height))
                bits_ = ShadowBits(tiles.width, tiles.height);
            maps_.select(known, maps_.count() - known);
            drawn(mark_);
            mark_.set("stride", stride_);
            bindTiles(mark_);
            return bits_.mark(mark_, frame.gbufferTextures, comparisons, tiles);
        }
        if (comparisons.empty()) return {};
        if (target_.width() != tiles.width || target_.height() != tiles.height)
            target_ = BlankTarget(tiles.width, tiles.height);
        const bool collected = collects() && maps_.tileCount() == 1;
        if (collected && known == 0) {
            drawn(collect_);
            collect_.set("stride", stride_);
            bindTiles(collect_);
            collected_.collect(collect_, target_, frame.gbufferTextures);
        }
        const gl::Program& differ = collected ? differCollected_ : differ_;
        drawn(differ);
        differ.set(*this);
        differ.set("stride", stride_);
        differ.set("depthUnitM", static_cast<float>(frame.lightBounds.whole.receiverFarM));
        if (collected)
            collected_.bind(differ);
        else
            bindTiles(differ);
        constexpr GLuint kCentreMapUnit = 2;
        const bool fromCentre = space_.is("light");
        if (fromCentre) centreMap_.map().bind(kCentreMapUnit);
        return queries_.count(collected ? collected_.target() : target_, frame.gbufferTextures,
                              comparisons, tiles, fromCentre ? maps_.tileCount() : 1,
                              [&](const MapComparison& comparison, int draw) {
                                  differ.set("compared", comparison);
                                  differ.set("centreTile", draw);
                              });
    }

    void bindTiles(const gl::Program& program) const {
        program.set("tilesDecided", tilesFound_ ? 1 : 0);
        if (tilesFound_) classes_.bind();
    }

    std::vector<float> finalWeights() const {
        using enum LightTreeWeights;
        return unitWeights(refinement_.tree(), weights_.is("leaf_area")     ? leafArea
                                               : weights_.is("local_depth") ? localDepth
                                                                            : equal);
    }

    void accumulate(const Frame& frame, const VisibilityTarget& target) {
        const gl::DebugGroup group("adaptive_light_sampled: accumulate");
        if (sum_.width() != target.width() || sum_.height() != target.height())
            sum_ = AccumulationBuffer(target.width(), target.height());
        sum_.clear();
        for (int i = 0; i < maps_.count(); ++i) {
            maps_.select(i, 1);
            drawn(add_);
            sum_.add(add_, frame.gbufferTextures);
        }
        maps_.select(0, maps_.count());
        resolve_.use();
        resolve_.set("totalWeight", maps_.weight());
        sum_.sum().bind(0);
        target.draw(resolve_, frame.gbufferTextures);
    }

    LightMaps maps_;
    DepthPass centreMap_;
    LightRefinement refinement_;
    BlankTarget target_;
    QueriedComparison queries_;
    CollectedReceivers collected_;
    ShadowBits bits_;
    LitTiles tiles_;
    PixelClasses classes_;
    AccumulationBuffer sum_;
    gl::Program oneMap_, all_, add_, resolve_, differ_, collect_, differCollected_, mark_,
        shadeBits_, undecided_;
    std::optional<Camera> builtFor_;
    int shadeMaps_ = 0;
    bool hard_ = false, tilesFound_ = false;
    Plan plan_;
};

const Register<AdaptiveLightSampled> entry{"adaptive_light_sampled", "Adaptive light sampling",
                                           "Schwaerzler 2009"};

}  // namespace
}  // namespace penumbra
