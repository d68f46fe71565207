#pragma once

#include "core/frame/casters.hpp"
#include "core/passes/slice_pass.hpp"

namespace penumbra {

/// How far down each body of a frame's casters goes, for SliceFill: a fragment of a body that goes
/// on below the lower boundary of its slice is drawn into the next one, too, so that no light
/// passes between the pieces of its surface.
class FillDepths {
  public:
    /// Bodies that are filled, by their mean thickness (Casters).
    enum class Bodies { any, thinnerThanASlice };

    FillDepths() = default;
    /// Finds the bodies of a scene's first frame.
    explicit FillDepths(const Geometry& geometry);

    /// The fill for `view`, which refers to this object; of no caster, with nothing uploaded, where
    /// no body that is filled crosses a boundary.
    SliceFill find(const Geometry& geometry, const SliceView& view, Bodies filled);
    /// Slices that the last find may fill.
    SliceSet filled() const { return filled_; }
    double mebibytes() const { return depths_.mebibytes(); }

  private:
    Casters casters_;
    gl::Texture depths_;  ///< R32F, see SliceFill
    SliceSet filled_ = 0;
};

}  // namespace penumbra
