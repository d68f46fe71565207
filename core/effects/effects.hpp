#pragma once

#include <array>
#include <bitset>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

/// Something a scene may or may not call for (DESIGN: "simulate only the effects a scene calls
/// for").
enum class Effect {
    penumbra,         ///< the light has extent that shows
    self_shadow,      ///< a caster shadows itself
    thin_casters,     ///< casters without thickness
    layered_casters,  ///< a light ray meets more than one caster
    alpha_mask,       ///< a caster is cut out by its texture's alpha
    moving_light,
    moving_casters,
    moving_camera,
};
inline constexpr std::size_t kEffectCount = 8;

struct EffectInfo {
    Effect effect;
    std::string_view id;  ///< as on the command line and in the CSV
    std::string_view doc;
};
const std::array<EffectInfo, kEffectCount>& allEffects();

/// A set of effects.
class EffectSet {
  public:
    EffectSet() = default;
    EffectSet(std::initializer_list<Effect> effects) {
        for (Effect e : effects) bits_.set(static_cast<std::size_t>(e));
    }
    static EffectSet all() {
        EffectSet s;
        s.bits_.set();
        return s;
    }
    bool has(Effect e) const { return bits_.test(static_cast<std::size_t>(e)); }
    EffectSet& add(Effect e) { return bits_.set(static_cast<std::size_t>(e)), *this; }
    EffectSet operator&(const EffectSet& o) const { return EffectSet(bits_ & o.bits_); }
    EffectSet operator-(const EffectSet& o) const { return EffectSet(bits_ & ~o.bits_); }
    bool operator==(const EffectSet&) const = default;
    bool empty() const { return bits_.none(); }
    /// Ids joined with ' ', in the order of the enum.
    std::string text() const;

  private:
    explicit EffectSet(std::bitset<kEffectCount> bits) : bits_(bits) {}
    std::bitset<kEffectCount> bits_;
};

/// What a method simulates in one frame: what the frame calls for and the method can do. The
/// harness makes it; a method reads it and leaves out everything that is not in it.
struct Plan {
    EffectSet simulated;  ///< called for and simulated
    EffectSet skipped;    ///< the method could, the frame does not call for it
    EffectSet missing;    ///< called for, beyond the method
    /// Every pixel gets all of the work, even where a conservative test (PixelClasses and its like)
    /// could answer for it: `--effects all`.
    bool everyPixel = false;
    bool has(Effect e) const { return simulated.has(e); }
    bool operator==(const Plan&) const = default;
};

/// `--effects`: auto (what the scene calls for), all, none, or a comma-separated list of ids.
/// Throws InputError naming the valid ids.
struct EffectChoice {
    bool automatic = true;
    EffectSet forced;
    EffectSet leftOut;  ///< of what the scene calls for, where automatic: to see what it costs
    bool everyPixel = false;  ///< `all`: nothing is left out at any pixel either
    static EffectChoice parse(const std::string& text);
};

/// What analysis found out about one effect in a frame.
struct EffectFinding {
    bool calledFor = true;
    std::string evidence;  ///< why, in words
    bool operator==(const EffectFinding&) const = default;
};

/// One finding for each effect.
class EffectFindings {
  public:
    EffectFinding& operator[](Effect e) { return findings_[static_cast<std::size_t>(e)]; }
    const EffectFinding& operator[](Effect e) const {
        return findings_[static_cast<std::size_t>(e)];
    }
    EffectSet calledFor() const;
    bool operator==(const EffectFindings&) const = default;

  private:
    std::array<EffectFinding, kEffectCount> findings_;
};

Plan planFor(const EffectChoice& choice, const EffectSet& calledFor, const EffectSet& canSimulate);

}  // namespace penumbra
