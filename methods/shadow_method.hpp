#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/frame/frame.hpp"
#include "core/gl/program.hpp"
#include "core/image/image.hpp"
#include "core/parameter/parameter.hpp"

namespace penumbra {

/// What a method can do and what it needs.
struct Traits {
    EffectSet simulates;
};

/// Where a method's answer goes: one R32F texel per pixel, row 0 the image's top row.
class VisibilityTarget {
  public:
    virtual ~VisibilityTarget() = default;
    virtual int width() const = 0;
    virtual int height() const = 0;
    /// Binds the target's framebuffer and viewport, sets the state of a full-screen pass (no depth
    /// test, no blending, no culling) and draws one triangle over it with `program`, which is in
    /// use with the G-buffer bound (shaders/common/receiver.glsl).
    virtual void draw(const gl::Program& program, const GBufferTextures& gbuffer) const = 0;
    /// For methods that compute on the CPU: width * height visibilities.
    virtual void upload(std::span<const float> visibility) const = 0;
};

/// Visible work that does not depend on the machine, counted by the method where GL cannot.
struct WorkCounters {
    int maps = 0;              ///< shadow maps rendered by the last build
    double lightTexels = 0.0;  ///< light-space texels they hold
    double textureMib = 0.0;   ///< memory of the method's own textures
    std::string message;       ///< what the row should say, usually empty
    int shadeMaps = 0;         ///< shadow maps rendered by the last shade, for another camera
};

/// Something between a method's passes that is worth looking at, by the name that its paper has for
/// it. Either a texture of the method's own, good until its next build, or a picture made for this.
struct NamedTexture {
    std::string name;
    const gl::Texture* texture = nullptr;
    std::shared_ptr<const Image> picture{};
    float lo = 0.0f, hi = 0.0f;  ///< values to show as black and white; equal: those that it has
};

/// One shadow technique. The harness calls prepare once per scene and size, build when something
/// that light space depends on moved, shade per frame; it owns timing, masks, seeds and readback.
/// A method keeps what it needs between the calls in members and reads nothing but its arguments.
/// It may throw Unsupported (the row says why) or any std::exception (the row is failed).
class ShadowMethod : public Parameters {
  public:
    virtual Traits traits() const = 0;
    /// Ordered settings, cheapest to best, that an accuracy-against-time curve walks.
    virtual std::vector<Assignments> ladder() const = 0;
    /// Allocate, compile for the plan.
    virtual void prepare(const Scene& scene, const Plan& plan) = 0;
    /// Light-space work.
    virtual void build(const Frame& frame, const Plan& plan) = 0;
    /// Per-pixel work: visibility V in [0,1] (1 lit) for every scored and horizon pixel.
    virtual void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) = 0;
    /// Drops what shade keeps for as long as the camera stays. Every frame of a moving camera finds
    /// another one: the harness says so before it measures one more than once.
    virtual void forgetCamera() {}
    virtual WorkCounters counters() const { return {}; }
    /// What the last frame left, for people to look at. Textures that this plan or setting has no
    /// use for may be listed without having been made.
    virtual std::vector<NamedTexture> textures() const { return {}; }
};

struct MethodInfo {
    std::string id;  ///< file stem, command line name, CSV value
    std::string title;
    std::string source;  ///< paper
    std::function<std::unique_ptr<ShadowMethod>()> make;
};

/// Every registered method, sorted by id. Registration happens during static initialisation; the
/// methods are linked as an OBJECT library because a static library would drop them.
const std::vector<MethodInfo>& methodRegistry();

/// Throws InputError listing the known ids.
const MethodInfo& findMethod(const std::string& id);

void registerMethod(MethodInfo info);

/// `const Register<Pcss> entry{"pcss", "Percentage-closer soft shadows", "Fernando 2005"};`
template <class Method>
struct Register {
    Register(std::string id, std::string title, std::string source) {
        registerMethod({std::move(id), std::move(title), std::move(source),
                        [] { return std::make_unique<Method>(); }});
    }
};

}  // namespace penumbra
