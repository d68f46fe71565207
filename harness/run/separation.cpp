#include "harness/run/separation.hpp"

#include <limits>

namespace penumbra {

std::vector<float> separationImage(const Reference& reference, const GBuffer& gbuffer) {
    std::vector<float> image = reference.visibility;
    for (std::size_t i = 0; i < image.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored && gbuffer.mask[i] != PixelClass::horizon)
            continue;
        const float unshadowed = reference.irradianceUnshadowed[i];
        image[i] = unshadowed > 0.0f ? reference.irradiance[i] / unshadowed
                                     : std::numeric_limits<float>::quiet_NaN();
    }
    return image;
}

Row separationRow(const Frame& frame) {
    Row row;
    row.scene = frame.scene.id;
    row.frame = frame.index;
    row.method = row.setting = kSeparation;
    row.width = frame.width();
    row.height = frame.height();
    return row;
}

}  // namespace penumbra
