#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>
#include <string_view>

#include "core/frame/gbuffer.hpp"
#include "core/image/image.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// Pictures of a visibility image, for people to look at: linear RGB, channels R, G, B, as large as
/// the G-buffer. The metric flip reads them too; nothing else does.

/// The error at which the colour scale ends, on every picture, so that any two can be compared.
constexpr float kErrorScale = 0.25F;

/// How one frame is lit in pictures; the same for every method, so that brightness can be compared.
struct PictureLight {
    float radiance = 1.0F;           ///< of the area light; includes the exposure
    float ambientIrradiance = 0.0F;  ///< keeps the umbra from pure black; exists in pictures only
};

/// Chosen from the frame without shadows: the 95th percentile of its luminance maps to 0.8, the
/// ambient light is 4 % of the 95th percentile of its irradiance.
PictureLight pictureLight(const GBuffer& gbuffer);

/// albedo / pi * (unshadowed irradiance * visibility + ambient), on dark grey. Visibility outside
/// [0,1] is clamped (the error map shows it), non-finite pixels are magenta.
Image shadeVisibility(const GBuffer& gbuffer, std::span<const float> visibility,
                      const PictureLight& light);

/// Linear RGB of a signed error: white at 0, through to full blue at -kErrorScale (too dark) and
/// full red at +kErrorScale (leaks light), constant beyond; magenta if not finite. Mirrored errors
/// have red and blue exchanged.
glm::vec3 errorColour(float error);

/// visibility - reference in errorColour over scored and horizon pixels; pixels that nobody answers
/// for (background, facing away) carry a dim grey hatching that no error can have.
Image errorMap(const GBuffer& gbuffer, std::span<const float> visibility,
               const Reference& reference);

struct ClassColour {
    std::string_view name;
    glm::vec3 rgb;  ///< linear
};
/// What classMap paints, in this order: lit, penumbra, umbra, horizon.
const std::array<ClassColour, 4>& classColours();

/// What the reference says of each pixel, as flat colours; the hatching of errorMap elsewhere.
Image classMap(const GBuffer& gbuffer, const Reference& reference);

}  // namespace penumbra
