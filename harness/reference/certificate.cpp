#include "harness/reference/certificate.hpp"

#include <algorithm>
#include <cmath>

#include "harness/reference/exact.hpp"

namespace penumbra {

void Certificate::add(double truth, double traced, double standardError) {
    const double error = traced - truth;
    worst = std::max(worst, std::abs(error));
    if (truth < 1.0 / 255 || truth > 1.0 - 1.0 / 255) return;
    ++pixels;
    covered += std::abs(error) <= kInterval * standardError;
    squaredError += error * error;
    squaredStandardised += error * error / (standardError * standardError);
}

void Certificate::add(const Certificate& other) {
    pixels += other.pixels;
    covered += other.covered;
    squaredError += other.squaredError;
    squaredStandardised += other.squaredStandardised;
    worst = std::max(worst, other.worst);
}

double Certificate::rmse() const {
    return std::sqrt(squaredError / pixels);
}

Certificate certify(const Reference& traced, const Tracer& tracer,
                    const std::vector<Material>& materials, const GBuffer& gbuffer,
                    const AreaLight& light, std::size_t sample) {
    Certificate certificate;
    if (light.isPoint() || firstMasked(tracer.geometry(), materials)) return certificate;
    const std::vector<LightClass> classes = classifyLight(traced, gbuffer);
    const auto penumbra =
        static_cast<std::size_t>(std::ranges::count(classes, LightClass::penumbra));
    GBuffer asked = gbuffer;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (classes[i] == LightClass::penumbra) ++seen;
        // Those at which seen * sample / penumbra steps to another whole number.
        const bool isAsked = classes[i] == LightClass::penumbra &&
                             seen * sample / penumbra != (seen - 1) * sample / penumbra;
        if (!isAsked) asked.mask[i] = PixelClass::background;
    }
    const Reference exact = exactReference(tracer, materials, asked, light);
    for (std::size_t i = 0; i < gbuffer.size(); ++i)
        if (asked.mask[i] == PixelClass::scored && exact.rays[i] == 0.0f)
            certificate.add(exact.visibility[i], traced.visibility[i], traced.standardError[i]);
    return certificate;
}

}  // namespace penumbra
