// Penumbra quads: every silhouette edge seen from the light's centre grows two quads in light
// space, one away from its caster and one over it, which carry visibility from 1/2 at the edge to 1
// and to 0 into an outer and an inner penumbra map (Arvo, Westerholm 2004; METHODS.md 14).
// Receivers in the first shadow map read the outer map, those in the second, peeled from the front
// faces behind the first, the inner one, and all others are dark (section 4.4). The vertex shader
// stretches edges, a compute pass before it lists those that are silhouettes: sending all of them
// through as degenerate quads, as the paper must and overlap=draw_order still does, makes a build
// of 170,000 to 300,000 edges 1.4 times as long. The CPU only follows moving casters
// (core/scene/edge_adjacency.hpp).
//
// Right for one straight edge over one receiver: there, `stretch=texel` and `profile=exact` give
// the rectangular light's very visibility, while the paper's far plane, put into the farthest
// receiver's depth, widens penumbrae on receivers before it by (1/zA - 1/zf) / (1/zA - 1/zr). Where
// penumbrae overlap, minimum (outer) and maximum (inner) stand in for the union of casters, in any
// order of drawing; the paper's hardware kept what was drawn last (overlap=draw_order).
//
// Wrong by design: the third surface from the light is dark even in a penumbra (layers, fig. 7).
// Each edge's quad knows nothing of the caster's other edge: one narrower than its penumbra keeps a
// dark core of at least one half, so that wires are worse than in a hard map (antennas), and an
// inner quad that reaches past a narrow part lights what another part shadows (teapot).
// Silhouettes are those of the light's centre. Casters cut out by alpha have no edges, and
// receivers beyond 70 degrees no single light view: both are refused. Meshes that are not closed
// two-manifolds are drawn as EdgeAdjacency says, their defects counted in the row's message.
//
// Of a plan only penumbra and thin_casters, whose first map has both sides, matter: the second and
// the inner map hold the inner half of every penumbra, of one layer, too; the maps must have all
// parts, also those that shadow nothing, for quads are stretched to the surfaces they fall upon;
// and a pixel is four gathers, which a test of its tile would cost as well.

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/frame/gpu_faces.hpp"
#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/farthest_pyramid.hpp"
#include "methods/map_bias.hpp"
#include "methods/quad_outline.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class PenumbraQuads : public ShadowMethod {
    IntParameter mapSize_{this,
                          "map_size",
                          1024,
                          16,
                          16384,
                          "texels",
                          "side of the shadow maps and the penumbra maps"};
    ChoiceParameter stretch_{
        this,
        "stretch",
        {"texel", "vertex", "far_plane"},
        "penumbrae as wide as the receiver in each texel makes them, as the one beside each "
        "silhouette vertex does, or as one in the farthest receiver's depth would (the paper)"};
    ChoiceParameter corners_{
        this,
        "corners",
        {"filled", "averaged"},
        "edges move by the light's farthest point across them and corners between are filled, or "
        "vertices move along their averaged normals alone, narrower at corners (the paper)"};
    ChoiceParameter profile_{this,
                             "profile",
                             {"exact", "linear"},
                             "visibility across the penumbra: a rectangular light's beyond a "
                             "straight edge, or a linear ramp (the paper)"};
    ChoiceParameter overlap_{this,
                             "overlap",
                             {"min_max", "draw_order"},
                             "where quads overlap: the least outer and the greatest inner "
                             "visibility, or the quad drawn last (the paper)"};
    ChoiceParameter inner_{
        this,
        "inner",
        {"seen", "pieces", "all"},
        "inner quads only where the light's centre, just past their edge, sees about as deep as "
        "where they fall; only over their own piece of a caster cut apart in its hollows (the "
        "paper's identities); or everywhere (the paper)"};
    BoolParameter weld_{this, "weld", true,
                        "weld vertices, drop back-to-back triangles, split T-junctions; off, the "
                        "mesh is taken as it is and its seams cast false penumbrae"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all() - EffectSet{Effect::alpha_mask}}; }

    std::vector<Assignments> ladder() const override {
        return {{{"map_size", "256"}, {"stretch", "far_plane"}, {"corners", "averaged"}},
                {{"map_size", "256"}},
                {{"map_size", "512"}},
                {{"map_size", "1024"}},
                {{"map_size", "2048"}}};
    }

    void prepare(const Scene& scene, const Plan& plan) override {
        if (plan.missing.has(Effect::alpha_mask) &&
            std::ranges::any_of(scene.materials, &Material::masked))
            throw Unsupported(
                "casters are cut out by their textures' alpha: such outlines have no edges to grow "
                "quads from");
        depth_ = DepthPass(plan);
        hard_ = gl::Program::graphics("hard.glsl");
        if (!plan.has(Effect::penumbra)) return;
        second_ = gl::Program::graphics("penumbra_quads.glsl", {"PASS_SECOND"});
        piece_ = gl::Program::graphics("penumbra_quads.glsl", {"PASS_PIECES"});
        soft_ = gl::Program::graphics("penumbra_quads.glsl", {"PASS_SHADE"});
        std::vector<std::string> defines = {"PASS_QUADS", "OUTER"};
        if (stretch_.is("texel")) defines.emplace_back("RECEIVER_TEXEL");
        if (stretch_.is("vertex")) defines.emplace_back("RECEIVER_VERTEX");
        if (corners_.is("averaged")) defines.emplace_back("STRETCH_AVERAGED");
        if (profile_.is("linear")) defines.emplace_back("PROFILE_LINEAR");
        if (inner_.is("seen")) defines.emplace_back("INNER_SEEN");
        if (inner_.is("pieces")) defines.emplace_back("INNER_PIECES");
        outerQuads_ = gl::Program::graphics("penumbra_quads.glsl", defines);
        defines[1] = "INNER";
        innerQuads_ = gl::Program::graphics("penumbra_quads.glsl", defines);
        defines[0] = "PASS_EDGES";
        if (overlap_.is("draw_order")) defines.emplace_back("ORDERED");
        silhouette_ = gl::Program::compute("penumbra_quads.glsl", defines);
        if (stretch_.is("texel")) farthest_ = FarthestPyramid::create();
        draw_ = gl::Buffer::create(5 * sizeof(GLuint), nullptr, GL_DYNAMIC_STORAGE_BIT);
        GLuint id = 0;
        glCreateFramebuffers(1, &id);
        framebuffer_ = gl::Framebuffer(id);
        outline_ = QuadOutline::create();
        geometry_.reset();
        adjacency_ = {};
        useGeometry(scene.frame(0).geometry);
    }

    void build(const Frame& frame, const Plan& plan) override {
        const LightView view = LightView::fit(frame, glm::dvec2(0.0), mapSize_);
        soften_ = plan.has(Effect::penumbra) && !frame.light.isPoint();
        if (soften_ && view.tiles.size() > 1)
            throw Unsupported(
                "receivers lie more than 70 degrees off the light's normal: one light view cannot "
                "hold their penumbra quads");
        depth_.render(frame, view, mapSize_);
        if (!soften_) return;
        useGeometry(frame.geometry);
        fitFrame(frame);
        renderSecond();
        if (boundsQuads()) farthest_.build({&depth_.map(), &secondMap_});
        if (inner_.is("pieces")) renderPieces();
        listSilhouettes(frame.light);
        renderQuads(frame.light);
    }

    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        const gl::DebugGroup group("penumbra quads: combine");
        const gl::Program& program = soften_ ? soft_ : hard_;
        program.use();
        depth_.bind(program, 0);
        program.set("biasTexels", static_cast<float>(bias_));
        if (soften_) {
            secondMap_.bind(1);
            penumbraMap_.bind(2);
            program.set("filterTexels", static_cast<float>(filterTexels_));
        }
        target.draw(program, frame.gbufferTextures);
    }

    WorkCounters counters() const override {
        if (!soften_) return {depth_.map().layers(), depth_.texels(), depth_.map().mebibytes(), ""};
        const std::string defects = adjacency_.defects().text();
        return {
            4, 4.0 * depth_.texels(),
            depth_.map().mebibytes() + secondMap_.mebibytes() + penumbraMap_.mebibytes() +
                pieceMap_.mebibytes() + pieceDepth_.mebibytes() + farthest_.texture().mebibytes(),
            defects.empty() ? "" : fmt::format("{} edges: {}", adjacency_.edgeCount(), defects)};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()},
                {"second depth layer", &secondMap_},
                {"penumbra maps, outer and inner", &penumbraMap_},
                {"pieces", &pieceMap_},
                {"farthest depth pyramid", &farthest_.texture()}};
    }

  private:
    static constexpr int kBoundedEdges = 1 << 15;
    static constexpr double kNearerTexels = 2.0;  ///< quads closer to a surface lie on it
    static constexpr double kBehindTexels = 0.5;  ///< surfaces closer to the first are the first

    /// Uploads the frame's edges and faces unless they are there.
    void useGeometry(const std::shared_ptr<const Geometry>& geometry) {
        if (geometry == geometry_) return;
        geometry_ = geometry;
        if (!adjacency_.describes(*geometry)) {
            adjacency_ = EdgeAdjacency(*geometry, weld_);
            faces_ = GpuFaces(adjacency_);
        }
        faces_.place(*geometry);
        outline_.upload(adjacency_.outlineEdges(*geometry));
    }

    void fitFrame(const Frame& frame) {
        const LightTile& tile = depth_.view().tiles[0];
        const glm::dvec2 size = tile.tangentSize();
        texelTangent_ = std::max(size.x, size.y) / mapSize_;
        farM_ = std::max(frame.lightBounds.whole.receiverFarM, tile.nearM);
        // Half a texel to both sides smooths the maps' steps; where all penumbrae are narrower,
        // it would widen them.
        const double nearestM = std::clamp(frame.lightBounds.whole.casterNearM, tile.nearM, farM_);
        const double widestM =
            2.0 * std::max(frame.light.halfU, frame.light.halfV) * (1.0 / nearestM - 1.0 / farM_);
        filterTexels_ = std::clamp(widestM / std::min(size.x, size.y) * mapSize_, 1e-6, 1.0);
        if (secondMap_.width() == mapSize_) return;
        secondMap_ = gl::Texture::createArray(GL_DEPTH_COMPONENT32F, mapSize_, mapSize_, 1);
        penumbraMap_ = gl::Texture::createArray(GL_R32F, mapSize_, mapSize_, 2);
        if (!inner_.is("pieces")) return;
        pieceMap_ = gl::Texture::create2D(GL_R32UI, mapSize_, mapSize_);
        pieceDepth_ = gl::Texture::create2D(GL_DEPTH_COMPONENT32F, mapSize_, mapSize_);
    }

    void attach(GLenum attachment, const gl::Texture* texture, int layer) const {
        if (texture && texture->layers() > 0)
            glNamedFramebufferTextureLayer(framebuffer_.id(), attachment, texture->id(), 0, layer);
        else
            glNamedFramebufferTexture(framebuffer_.id(), attachment, texture ? texture->id() : 0,
                                      0);
    }

    /// The framebuffer on these textures, and the state of a pass over the light's view. The depth
    /// is cleared unless it is `kept`, which also protects it.
    void beginPass(const gl::Texture* colour, int layer, const gl::Texture& depth,
                   bool kept = false) const {
        attach(GL_DEPTH_ATTACHMENT, &depth, 0);
        attach(GL_COLOR_ATTACHMENT0, colour, layer);
        glNamedFramebufferDrawBuffer(framebuffer_.id(), colour ? GL_COLOR_ATTACHMENT0 : GL_NONE);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_GREATER);
        glDepthMask(!kept);
        glEnable(GL_DEPTH_CLAMP);
        glDisable(GL_CULL_FACE);
        glDisable(GL_BLEND);
        glDisable(GL_POLYGON_OFFSET_FILL);
        glDisable(GL_SCISSOR_TEST);
        glViewport(0, 0, mapSize_, mapSize_);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
        constexpr float kNothing = 0.0f;
        if (!kept) glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kNothing);
    }
    static void endPass() {
        glDisable(GL_DEPTH_CLAMP);
        glDisable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
    }

    void renderSecond() const {
        const gl::DebugGroup group("penumbra quads: second front faces");
        beginPass(nullptr, 0, secondMap_);
        second_.use();
        depth_.map().bind(0);
        second_.set("behind", static_cast<float>(1.0 - kBehindTexels * texelTangent_));
        second_.set("clipFromWorld", depth_.view().clipFromWorld(0));
        faces_.draw(second_, GL_BACK);
        endPass();
    }

    void renderPieces() const {
        const gl::DebugGroup group("penumbra quads: pieces of the nearest back faces");
        beginPass(&pieceMap_, 0, pieceDepth_);
        constexpr GLuint kNoPiece[4] = {0xffffffffu, 0, 0, 0};
        glClearNamedFramebufferuiv(framebuffer_.id(), GL_COLOR, 0, kNoPiece);
        piece_.use();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, faces_.pieces().id());
        piece_.set("clipFromWorld", depth_.view().clipFromWorld(0));
        faces_.draw(piece_, GL_FRONT);
        endPass();
    }

    /// Whether each quad is stretched as far as its own receivers only. Few have fewer fragments
    /// than the pyramid over the maps has texels to read.
    bool boundsQuads() const { return stretch_.is("texel") && outline_.count() >= kBoundedEdges; }
    double nearer() const { return 1.0 + kNearerTexels * texelTangent_; }

    /// Uniforms of what the edges and their quads are seen by.
    void setView(const gl::Program& program, const AreaLight& light) const {
        const LightTile& tile = depth_.view().tiles[0];
        program.set("lightCentre", glm::vec3(light.centre));
        program.set("lightAxes",
                    glm::mat3(glm::transpose(glm::dmat3(tile.axisX, tile.axisY, tile.axisZ))));
        program.set("tangents", glm::vec4(tile.tangentLo, 1.0 / tile.tangentSize()));
        program.set("nearM", static_cast<float>(tile.nearM));
        program.set("nearer", static_cast<float>(nearer()));
        program.set("mapSize", static_cast<int>(mapSize_));
        program.set("lightHalfM", glm::vec2(light.halfU, light.halfV));
        program.set("farS", static_cast<float>(tile.nearM / farM_));
        program.set("texelTangent", static_cast<float>(texelTangent_));
    }

    void listSilhouettes(const AreaLight& light) const {
        const gl::DebugGroup group("penumbra quads: silhouettes");
        constexpr GLuint kEmpty[5] = {0, 1, 0, 0, 0};
        glNamedBufferSubData(draw_.id(), 0, sizeof(kEmpty), kEmpty);
        silhouette_.use();
        setView(silhouette_, light);
        silhouette_.set("edgeCount", outline_.count());
        depth_.map().bind(0);
        if (boundsQuads()) farthest_.texture().bind(1);
        silhouette_.set("boundQuads", boundsQuads());
        outline_.bind();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, draw_.id());
        // In rows, for no side of a dispatch need take more than 65535 groups.
        constexpr GLuint kGroupsAcross = 16384;
        const GLuint groups = static_cast<GLuint>(outline_.count() + 63) / 64;
        glDispatchCompute(std::min(groups, kGroupsAcross),
                          (groups + kGroupsAcross - 1) / kGroupsAcross, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    }

    /// Tested against the map that they fall upon as the paper does, which is fetched as well: it
    /// is not written.
    void renderQuads(const AreaLight& light) const {
        const gl::DebugGroup group("penumbra quads: outer and inner");
        outline_.bind();
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draw_.id());
        // Quads that lie on a surface fail against it.
        glDepthRange(0.0, 1.0 / nearer());
        for (const bool outer : {true, false}) {
            const gl::Texture& receivers = outer ? depth_.map() : secondMap_;
            beginPass(&penumbraMap_, outer ? 0 : 1, receivers, true);
            const float clear[4] = {outer ? 1.0f : 0.0f, 0.0f, 0.0f, 0.0f};
            glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, clear);
            if (overlap_.is("min_max")) {
                glEnable(GL_BLEND);
                glBlendEquation(outer ? GL_MIN : GL_MAX);
            }
            const gl::Program& quads = outer ? outerQuads_ : innerQuads_;
            quads.use();
            receivers.bind(0);
            if (inner_.is("pieces")) pieceMap_.bind(1);
            depth_.map().bind(2);
            quads.set("clipFromWorld", depth_.view().clipFromWorld(0));
            setView(quads, light);
            glBindVertexArray(outline_.quads().id());
            glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr);
            glDisable(GL_BLEND);
            glBlendEquation(GL_FUNC_ADD);
            endPass();
        }
        glDepthRange(0.0, 1.0);
        glBindVertexArray(0);
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
    }

    DepthPass depth_;
    gl::Program hard_, second_, piece_, silhouette_, outerQuads_, innerQuads_, soft_;
    FarthestPyramid farthest_;
    gl::Framebuffer framebuffer_;
    std::shared_ptr<const Geometry> geometry_;
    EdgeAdjacency adjacency_;
    GpuFaces faces_;
    QuadOutline outline_;
    gl::Buffer draw_;
    gl::Texture secondMap_, penumbraMap_, pieceMap_, pieceDepth_;
    bool soften_ = false;
    double texelTangent_ = 0.0;  ///< width of a texel over its depth
    double farM_ = 0.0, filterTexels_ = 1.0;
};

const Register<PenumbraQuads> entry{"penumbra_quads", "Penumbra quads", "Arvo, Westerholm 2004"};

}  // namespace
}  // namespace penumbra
