#include "harness/study/varied_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "core/error.hpp"

namespace penumbra {
namespace {

/// Adds the middles of a part's edges to `out`, each once.
class Middles {
  public:
    explicit Middles(Geometry& out) : out_(out) {}
    std::uint32_t between(std::uint32_t a, std::uint32_t b) {
        const auto key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
        const auto [at, isNew] =
            known_.emplace(key, static_cast<std::uint32_t>(out_.positions.size()));
        if (isNew) {
            out_.positions.push_back(0.5f * (out_.positions[a] + out_.positions[b]));
            const glm::vec3 sum = out_.normals[a] + out_.normals[b];
            const float length = glm::length(sum);
            out_.normals.push_back(length > 0.0f ? sum / length : out_.normals[a]);
            out_.uvs.push_back(0.5f * (out_.uvs[a] + out_.uvs[b]));
        }
        return at->second;
    }

  private:
    Geometry& out_;
    std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

std::shared_ptr<const Geometry> subdividedOnce(const Geometry& in) {
    auto out = std::make_shared<Geometry>();
    out->indices.reserve(4 * in.indices.size());
    for (const Part& part : in.parts) {
        Part finer = part;
        finer.firstVertex = static_cast<std::uint32_t>(out->positions.size());
        finer.firstIndex = static_cast<std::uint32_t>(out->indices.size());
        const auto copy = [&](const auto& from, auto& to) {
            const auto first = from.begin() + part.firstVertex;
            to.insert(to.end(), first, first + part.vertexCount);
        };
        copy(in.positions, out->positions);
        copy(in.normals, out->normals);
        copy(in.uvs, out->uvs);
        Middles middles(*out);
        for (std::uint32_t i = part.firstIndex; i < part.firstIndex + part.indexCount; i += 3) {
            const auto corner = [&](std::uint32_t c) {
                return in.indices[i + c] - part.firstVertex + finer.firstVertex;
            };
            const std::uint32_t a = corner(0), b = corner(1), c = corner(2);
            const std::uint32_t ab = middles.between(a, b), bc = middles.between(b, c),
                                ca = middles.between(c, a);
            for (const std::uint32_t index : {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca})
                out->indices.push_back(index);
        }
        finer.vertexCount = static_cast<std::uint32_t>(out->positions.size()) - finer.firstVertex;
        finer.indexCount = static_cast<std::uint32_t>(out->indices.size()) - finer.firstIndex;
        out->parts.push_back(finer);
    }
    return out;
}

class VariedScene final : public Scene {
  public:
    VariedScene(std::shared_ptr<const Scene> base, const Variation& variation)
        : Scene(*base), base_(std::move(base)), variation_(variation) {}

    int frameCount() const override { return base_->frameCount(); }
    SceneFrame frame(int index) const override {
        SceneFrame frame = base_->frame(index);
        frame.light.halfU *= variation_.lightScale;
        frame.light.halfV *= variation_.lightScale;
        if (variation_.subdivisions > 0) frame.geometry = finer(frame.geometry);
        return frame;
    }

  private:
    /// Frames that share a geometry share the subdivided one, too.
    std::shared_ptr<const Geometry> finer(const std::shared_ptr<const Geometry>& coarse) const {
        const std::lock_guard lock(mutex_);
        if (coarse != coarse_) {
            finer_ = subdivided(coarse, variation_.subdivisions);
            coarse_ = coarse;
        }
        return finer_;
    }

    std::shared_ptr<const Scene> base_;
    Variation variation_;
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const Geometry> coarse_, finer_;  ///< of the frame asked for last
};

}  // namespace

std::shared_ptr<const Geometry> subdivided(std::shared_ptr<const Geometry> geometry, int times) {
    for (int i = 0; i < times; ++i) {
        if (4 * geometry->triangleCount() > kMostTriangles)
            throw InputError(fmt::format("{} triangles cut in four are more than {}",
                                         geometry->triangleCount(), kMostTriangles));
        geometry = subdividedOnce(*geometry);
    }
    return geometry;
}

std::shared_ptr<const Scene> varied(std::shared_ptr<const Scene> scene,
                                    const Variation& variation) {
    if (variation == Variation{}) return scene;
    return std::make_shared<VariedScene>(std::move(scene), variation);
}

}  // namespace penumbra
