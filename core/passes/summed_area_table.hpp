#pragma once

#include <glm/glm.hpp>

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Means over any rectangle of a two-channel texture from sixteen fetches (Crow 1984; Lauritzen
/// 2007 for statistics of depth). The table's texel (x, y) holds the sum of all source texels left
/// of x and above y, so it is one texel larger than its source each way and a box needs no case
/// for the border. shaders/common/summed_area_table.glsl looks boxes up, fractional corners too.
class SummedAreaTable {
  public:
    enum class Kind {
        /// RG32UI, fixed point, sums modulo 2^32. The difference of corners is exact as long as the
        /// box's own sum is below 2^32, whatever the table's entries have wrapped to.
        uint32,
        /// RG32F of the source less its mean, which keeps sums of noise near 0. Sums of anything
        /// with large structure grow with the map and lose the small boxes' digits.
        float32,
        /// RG32F of the source itself: what that mean is subtracted against, for tests.
        float32_with_mean,
    };

    SummedAreaTable() = default;
    /// For the current context.
    static SummedAreaTable create(Kind kind);

    /// Sums all layers of `source`, a float or normalized 2D array texture whose two channels are
    /// in [-1, 1]; values outside are clamped to it where the table is of integers. `maxBoxTexels`
    /// is the area of the largest box that will be asked for: fewer leave an integer table more
    /// digits. The lookup shrinks larger boxes to it around their centres.
    void build(const gl::Texture& source, double maxBoxTexels);

    /// Step of a source value in an integer table for boxes of up to `maxBoxTexels`: each texel is
    /// rounded to it.
    static double stepOf(double maxBoxTexels);
    /// By how much that rounding shifts a mean at most: half a step, 0 for floats.
    double stepError() const;
    /// Error of the mean of a box of one texel, of one of n texels an n-th, that the rounding of
    /// float sums leaves: half a unit in the last place of the sum over a quarter of the map, what
    /// large structure comes to after the mean is subtracted, at half the greatest value. 0 for
    /// integers.
    double sumError() const;
    /// Area of the largest box, texels: as asked for, or the whole map where sums are floats.
    double maxBoxTexels() const { return maxBoxTexels_; }
    double mebibytes() const;
    const gl::Texture& table() const { return table_; }
    /// Binds the table to `unit` and its mean to `unit` + 1 and sets the lookup's uniforms.
    void bind(const gl::Program& program, GLuint unit) const;

  private:
    bool integer() const { return kind_ == Kind::uint32; }
    GLenum format() const;

    Kind kind_ = Kind::uint32;
    gl::Program rows_, columns_, rowMeans_, mean_;
    gl::Texture table_;  ///< (width + 1) x (height + 1)
    gl::Texture means_;  ///< of rows, and of all in the column after them: 1 x (height + 1)
    double maxBoxTexels_ = 0.0, stepsPerUnit_ = 0.0;
};

}  // namespace penumbra
