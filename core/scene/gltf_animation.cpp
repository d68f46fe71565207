#include "core/scene/gltf_animation.hpp"

#include <fmt/format.h>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

class AnimationReader {
  public:
    AnimationReader(const tinygltf::Model& model, AccessorReader& reader,
                    const std::vector<int>& newIndex, Asset& asset)
        : model_(model), reader_(reader), newIndex_(newIndex), asset_(asset) {}

    void read(std::size_t index) {
        const tinygltf::Animation& animation = model_.animations[index];
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const tinygltf::AnimationChannel& channel = animation.channels[c];
            const std::string pointer = fmt::format("/animations/{}/channels/{}", index, c);
            if (channel.target_node < 0) continue;  // an extension's target
            require(channel.target_node, model_.nodes.size(), pointer + "/target/node", "node");
            require(channel.sampler, animation.samplers.size(), pointer + "/sampler", "sampler");
            const int node = newIndex_[channel.target_node];
            if (node < 0) continue;  // of another scene
            const tinygltf::AnimationSampler& sampler = animation.samplers[channel.sampler];
            const std::string samplerPointer =
                fmt::format("/animations/{}/samplers/{}", index, channel.sampler);
            if (channel.target_path == "weights") {
                addWeights(node, sampler, pointer, samplerPointer);
            } else {
                addTransform(node, channel, sampler, pointer, samplerPointer);
            }
        }
    }

  private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
        failInput(asset_.file, pointer, what);
    }

    void require(int index, std::size_t count, const std::string& pointer, const char* what) const {
        if (index >= 0 && static_cast<std::size_t>(index) < count) return;
        fail(pointer, fmt::format("{} {} does not exist; the file has {}", what, index, count));
    }

    void addTransform(int node, const tinygltf::AnimationChannel& channel,
                      const tinygltf::AnimationSampler& sampler, const std::string& pointer,
                      const std::string& samplerPointer) {
        NodeTrack track;
        track.node = node;
        if (channel.target_path == "translation") {
            track.property = NodeProperty::translation;
        } else if (channel.target_path == "rotation") {
            track.property = NodeProperty::rotation;
        } else if (channel.target_path == "scale") {
            track.property = NodeProperty::scale;
        } else {
            fail(pointer + "/target/path",
                 fmt::format("'{}' is not one of translation, rotation, scale, weights",
                             oneLine(channel.target_path, 40)));
        }
        if (asset_.nodes[node].hasMatrix) {
            fail(pointer, fmt::format("animates node {}, which has a matrix", channel.target_node));
        }
        const bool rotation = track.property == NodeProperty::rotation;
        track.curve = timesOf(sampler, samplerPointer);
        track.curve.quaternion = rotation;
        const std::vector<glm::vec4> values =
            reader_.vectors(sampler.output, {rotation ? 4 : 3, Integers::normalised, false},
                            samplerPointer + "/output");
        const std::size_t perKey = valuesPerKey(track.curve);
        requireValues(values.size(), perKey * track.curve.times.size(), track.curve,
                      samplerPointer);
        charge(values.size(), samplerPointer);
        track.curve.values.assign(values.begin(), values.end());
        for (std::size_t k = perKey / 2; rotation && k < values.size(); k += perKey) {
            requireRotation(track.curve.values[k], asset_.file,
                            fmt::format("{}/output key {}", samplerPointer, k / perKey));
        }
        asset_.tracks.push_back(std::move(track));
    }

    /// The values of all targets follow each other within a key; with CUBICSPLINE first all
    /// in-tangents, then all values, then all out-tangents (glTF 2.0, section 3.11 and appendix C).
    void addWeights(int node, const tinygltf::AnimationSampler& sampler, const std::string& pointer,
                    const std::string& samplerPointer) {
        const std::size_t targets = asset_.nodes[node].weights.size();
        if (targets == 0) fail(pointer, "animates weights of a node without morph targets");
        const Curve times = timesOf(sampler, samplerPointer);
        const std::vector<glm::vec4> values = reader_.vectors(
            sampler.output, {1, Integers::normalised, false}, samplerPointer + "/output");
        const std::size_t perKey = valuesPerKey(times);
        requireValues(values.size(), targets * perKey * times.times.size(), times, samplerPointer);
        charge(values.size() + targets * times.times.size(), samplerPointer);
        for (std::size_t target = 0; target < targets; ++target) {
            NodeTrack track{node, NodeProperty::weight, times, static_cast<int>(target)};
            for (std::size_t k = target; k < values.size(); k += targets) {
                track.curve.values.emplace_back(values[k].x);
            }
            asset_.tracks.push_back(std::move(track));
        }
    }

    Curve timesOf(const tinygltf::AnimationSampler& sampler, const std::string& pointer) {
        Curve curve;
        if (sampler.interpolation == "STEP") {
            curve.interpolation = Interpolation::step;
        } else if (sampler.interpolation == "CUBICSPLINE") {
            curve.interpolation = Interpolation::cubicSpline;
        } else if (sampler.interpolation != "LINEAR") {
            fail(pointer + "/interpolation", fmt::format("'{}' is not LINEAR, STEP or CUBICSPLINE",
                                                         oneLine(sampler.interpolation, 40)));
        }
        for (const glm::vec4& time :
             reader_.vectors(sampler.input, {1, Integers::none, false}, pointer + "/input")) {
            if (!curve.times.empty() && time.x <= curve.times.back()) {
                fail(pointer + "/input", fmt::format("time {} at key {} does not increase", time.x,
                                                     curve.times.size()));
            }
            curve.times.push_back(time.x);
        }
        return curve;
    }

    static std::size_t valuesPerKey(const Curve& curve) {
        return curve.interpolation == Interpolation::cubicSpline ? 3 : 1;
    }

    void requireValues(std::size_t count, std::size_t expected, const Curve& curve,
                       const std::string& pointer) const {
        if (count == expected) return;
        fail(pointer, fmt::format("has {} output values for {} keys", count, curve.times.size()));
    }

    void charge(std::size_t values, const std::string& pointer) {
        asset_.memory.charge(values, sizeof(glm::dvec4), pointer, "its keys");
    }

    const tinygltf::Model& model_;
    AccessorReader& reader_;
    const std::vector<int>& newIndex_;
    Asset& asset_;
};

}  // namespace

void readAnimations(const tinygltf::Model& model, AccessorReader& reader,
                    const std::vector<int>& newIndex, Asset& asset) {
    AnimationReader animations(model, reader, newIndex, asset);
    for (std::size_t i = 0; i < model.animations.size(); ++i) animations.read(i);
}

void requireRotation(const glm::dvec4& quaternion, const std::filesystem::path& file,
                     const std::string& pointer) {
    if (glm::length(quaternion) > 1e-6) return;
    failInput(file, pointer, "is not a rotation: its length is 0");
}

}  // namespace penumbra::scene_detail
