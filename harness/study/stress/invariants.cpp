#include "harness/study/stress/invariants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.hpp"
#include "core/frame/light_centre.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::stress {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool inRegion(const Trial& trial, const StageFrame& frame, std::size_t pixel) {
    const glm::dvec3 at =
        glm::dvec3(frame.frame().gbuffer.position[pixel]) + frame.frame().scene.origin;
    const Region& region = trial.hardCase.region;
    return glm::all(glm::greaterThanEqual(at, region.lo)) &&
           glm::all(glm::lessThanEqual(at, region.hi));
}

/// Pixels of the base scene's frame that are asked about and in the case's region.
std::vector<std::size_t> pixelsOf(const Trial& trial, std::size_t frame) {
    const StageFrame& base = *trial.stages[0]->frames()[frame];
    std::vector<std::size_t> pixels;
    for (const std::size_t i : base.asked())
        if (inRegion(trial, base, i)) pixels.push_back(i);
    if (pixels.empty())
        throw InputError(trial.hardCase.file.string() +
                         ": no pixel of its camera lies in the region: nothing is asked");
    return pixels;
}

std::string placeOf(const Trial& trial, std::size_t frame, std::size_t pixel) {
    const auto size = static_cast<std::size_t>(trial.stages[0]->size());
    return fmt::format("{}pixel {}, {}",
                       trial.stages[0]->frames().size() > 1 ? fmt::format("frame {} ", frame) : "",
                       pixel % size, pixel / size);
}

/// The worst of some pixels' deviations but for the share of them that may be worse.
class Worst {
  public:
    void add(double deviation, std::size_t pixel) {
        found_.emplace_back(std::isnan(deviation) ? kInfinity : deviation, pixel);
    }
    Finding finding(const Trial& trial, std::size_t frame) {
        if (found_.empty()) return {};
        const auto spared = std::min(
            found_.size() - 1,
            static_cast<std::size_t>(trial.hardCase.allowed * static_cast<double>(found_.size())));
        std::nth_element(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(spared),
                         found_.end(), std::greater<>());
        const auto& [deviation, pixel] = found_[spared];
        return {deviation, placeOf(trial, frame, pixel)};
    }

  private:
    std::vector<std::pair<double, std::size_t>> found_;
};

Finding worse(const Finding& a, const Finding& b) {
    return b.deviation > a.deviation ? b : a;
}

/// The worst over the base scene's frames of what `deviationOf(frame, pixel)` says.
template <class Deviation>
Finding perPixel(const Trial& trial, const Deviation& deviationOf) {
    Finding result;
    for (std::size_t f = 0; f < trial.images[0].size(); ++f) {
        Worst worst;
        for (const std::size_t i : pixelsOf(trial, f)) worst.add(deviationOf(f, i), i);
        result = worse(result, worst.finding(trial, f));
    }
    return result;
}

double beyondRange(float v) {
    if (!std::isfinite(v)) return kInfinity;
    return std::max({0.0, -static_cast<double>(v), static_cast<double>(v) - 1.0});
}

/// Of every image, of every variant, every pixel asked; no share is spared.
Finding range(const Trial& trial) {
    Finding result;
    for (std::size_t s = 0; s < trial.stages.size(); ++s)
        for (std::size_t f = 0; f < trial.images[s].size(); ++f)
            for (const std::size_t i : trial.stages[s]->frames()[f]->asked()) {
                const double beyond = beyondRange(trial.images[s][f][i]);
                if (beyond > result.deviation)
                    result = {beyond, (s > 0 ? trial.hardCase.variants[s - 1].name + ", " : "") +
                                          placeOf(trial, f, i)};
            }
    return result;
}

Finding value(const Trial& trial) {
    return perPixel(trial, [&](std::size_t f, std::size_t i) {
        return std::abs(trial.images[0][f][i] - trial.hardCase.value);
    });
}

Finding exact(const Trial& trial) {
    return perPixel(trial, [&](std::size_t f, std::size_t i) {
        return std::abs(trial.images[0][f][i] - trial.stages[0]->frames()[f]->exact()[i]);
    });
}

Finding hard(const Trial& trial) {
    return perPixel(trial, [&](std::size_t f, std::size_t i) {
        const auto seen =
            centreSeen(trial.stages[0]->frames()[f]->frame(), i, trial.hardCase.edgeM);
        return seen ? std::abs(trial.images[0][f][i] - (*seen ? 1.0 : 0.0)) : 0.0;
    });
}

/// Means over the pixels of a frame: of the image and of what `truthOf(frame, pixel)` says.
template <class Truth>
Finding ofMeans(const Trial& trial, const Truth& truthOf) {
    Finding result;
    for (std::size_t f = 0; f < trial.images[0].size(); ++f) {
        double image = 0.0, truth = 0.0;
        const std::vector<std::size_t> pixels = pixelsOf(trial, f);
        for (const std::size_t i : pixels) {
            image += trial.images[0][f][i];
            truth += truthOf(f, i);
        }
        const double n = static_cast<double>(pixels.size());
        result = worse(result, {std::abs(image - truth) / n,
                                fmt::format("mean {:.4f}, not {:.4f}", image / n, truth / n)});
    }
    return result;
}

Finding meanValue(const Trial& trial) {
    return ofMeans(trial, [&](std::size_t, std::size_t) { return trial.hardCase.value; });
}

Finding meanExact(const Trial& trial) {
    return ofMeans(trial, [&](std::size_t f, std::size_t i) {
        return static_cast<double>(trial.stages[0]->frames()[f]->exact()[i]);
    });
}

/// Where variant `v` shows what the base scene shows at pixel `i`.
std::size_t counterpart(const Trial& trial, std::size_t v, std::size_t i) {
    const auto size = static_cast<std::size_t>(trial.stages[0]->size());
    return trial.hardCase.variants[v].mirrored() ? i / size * size + (size - 1 - i % size) : i;
}

bool asked(const StageFrame& frame, std::size_t pixel) {
    return std::ranges::binary_search(frame.asked(), pixel);
}

Finding unchanged(const Trial& trial) {
    Finding result;
    for (std::size_t v = 0; v + 1 < trial.stages.size(); ++v)
        for (std::size_t f = 0; f < trial.images[0].size(); ++f) {
            Worst worst;
            for (const std::size_t i : pixelsOf(trial, f)) {
                const std::size_t other = counterpart(trial, v, i);
                if (!asked(*trial.stages[v + 1]->frames()[f], other)) continue;
                const float before = trial.images[0][f][i], after = trial.images[v + 1][f][other];
                worst.add(std::abs(static_cast<double>(before) - after), i);
            }
            Finding found = worst.finding(trial, f);
            found.where = trial.hardCase.variants[v].name + ", " + found.where;
            result = worse(result, found);
        }
    return result;
}

Finding meanUnchanged(const Trial& trial) {
    Finding result;
    for (std::size_t v = 0; v + 1 < trial.stages.size(); ++v) {
        const Finding found = ofMeans(trial, [&](std::size_t f, std::size_t i) {
            return static_cast<double>(trial.images[v + 1][f][counterpart(trial, v, i)]);
        });
        result =
            worse(result, {found.deviation, trial.hardCase.variants[v].name + ", " + found.where});
    }
    return result;
}

Finding monotone(const Trial& trial) {
    Finding result;
    const auto size = static_cast<std::size_t>(trial.stages[0]->size());
    for (std::size_t f = 0; f < trial.images[0].size(); ++f) {
        const StageFrame& frame = *trial.stages[0]->frames()[f];
        std::vector<std::vector<std::pair<double, std::size_t>>> rows(size);
        for (const std::size_t i : pixelsOf(trial, f))
            rows[i / size].emplace_back(
                glm::dot(glm::dvec3(frame.frame().gbuffer.position[i]), trial.hardCase.direction),
                i);
        Worst worst;
        for (auto& row : rows) {
            std::ranges::sort(row);
            float lightest = 0.0f;
            for (const auto& [along, i] : row) {
                const float v = trial.images[0][f][i];
                worst.add(static_cast<double>(lightest) - v, i);
                lightest = std::max(lightest, v);
            }
        }
        result = worse(result, worst.finding(trial, f));
    }
    return result;
}

Finding repeats(const Trial& trial) {
    const std::vector<Image> again = trial.again();
    Finding result;
    for (std::size_t f = 0; f < again.size(); ++f)
        for (const std::size_t i : trial.stages[0]->frames()[f]->asked())
            if (std::memcmp(&again[f][i], &trial.images[0][f][i], sizeof(float)) != 0) {
                // Not even the least bit may differ, so that it counts as 1 pixel, not by how much.
                result.deviation += 1.0;
                result.where = placeOf(trial, f, i);
            }
    return result;
}

}  // namespace

const std::vector<Invariant>& allInvariants() {
    static const std::vector<Invariant> invariants = {
        {"range", "all visibilities are finite and in [0, 1]; checked in every case", false, false,
         range},
        {"repeats", "two runs give the same bits; the deviation counts pixels", false, false,
         repeats},
        {"value", "visibility is `value` throughout the region", true, false, value},
        {"mean_value", "visibility is `value` on average over the region", true, false, meanValue},
        {"exact", "visibility is what the exact reference says", true, false, exact},
        {"mean_exact", "visibility is on average what the exact reference says", true, false,
         meanExact},
        {"hard", "visibility is that of the light's centre, further than `edge` from its shadow",
         true, false, hard},
        {"unchanged", "the variants' images are the base scene's", true, true, unchanged},
        {"mean_unchanged", "the variants' images are on average the base scene's", true, true,
         meanUnchanged},
        {"monotone", "along a row of the image it never gets darker towards `direction`", true,
         false, monotone},
    };
    return invariants;
}

const Invariant& findInvariant(const std::string& id) {
    std::vector<std::string> ids;
    for (const Invariant& invariant : allInvariants()) {
        if (invariant.id == id) return invariant;
        ids.push_back(invariant.id);
    }
    throw InputError(fmt::format("unknown invariant '{}'; there are {}",
                                 scene_detail::oneLine(id, 60), scene_detail::listed(ids)));
}

}  // namespace penumbra::stress
