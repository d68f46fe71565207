#include <fmt/format.h>
#include <xxhash.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "core/error.hpp"
#include "core/file/atomic_file.hpp"
#include "core/image/image.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

namespace {

/// Raise it with any change that alters what traceReference returns.
constexpr std::uint32_t kAlgorithmVersion = 4;

struct Channel {
    const char* name;
    std::vector<float> Reference::*values;
};
constexpr Channel kChannels[] = {{"visibility", &Reference::visibility},
                                 {"standard_error", &Reference::standardError},
                                 {"rays", &Reference::rays},
                                 {"irradiance", &Reference::irradiance},
                                 {"irradiance_unshadowed", &Reference::irradianceUnshadowed}};

class Hasher {
  public:
    Hasher() : state_(XXH3_createState(), XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

    template <class T>
    void add(const T& value) {
        // Padding bytes would make equal values differ.
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        XXH3_128bits_update(state_.get(), &value, sizeof value);
    }
    void add(const glm::dvec3& v) { add(v.x), add(v.y), add(v.z); }
    template <class T>
    void add(const std::vector<T>& values) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, float> ||
                      std::is_same_v<T, glm::vec2> || std::is_same_v<T, glm::vec3>);
        add(values.size());
        XXH3_128bits_update(state_.get(), values.data(), values.size() * sizeof(T));
    }

    std::string hex() const {
        XXH128_canonical_t canonical;
        XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
        std::string text;
        for (const unsigned char byte : canonical.digest)
            for (const int nibble : {byte >> 4, byte & 15}) text += "0123456789abcdef"[nibble];
        return text;
    }

  private:
    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

void addAlphaTexture(Hasher& hasher, const TextureImage& image) {
    hasher.add(image.width);
    hasher.add(image.height);
    hasher.add(image.wrapS);
    hasher.add(image.wrapT);
    hasher.add(image.linear);
    hasher.add(image.rgba);
}

void addCasters(Hasher& hasher, const Geometry& geometry, const std::vector<Material>& materials,
                const std::vector<TextureImage>& images) {
    hasher.add(geometry.positions);
    hasher.add(geometry.indices);
    bool masked = false;
    for (const Part& part : geometry.parts) {
        const Material& material = materials[part.material];
        hasher.add(part.firstIndex);
        hasher.add(part.indexCount);
        hasher.add(material.masked);
        if (!material.masked) continue;
        masked = true;
        hasher.add(material.baseColor.a);
        hasher.add(material.alphaCutoff);
        hasher.add(material.baseColorTexture);
        if (material.baseColorTexture >= 0)
            addAlphaTexture(hasher, images[material.baseColorTexture]);
    }
    if (masked) hasher.add(geometry.uvs);
}

constexpr std::string_view kExtension = ".exr";

/// An entry ends in this of all bytes before it, which an EXR reader does not look at. The image's
/// own compression notices most damage, but not where a block is stored as it is.
std::string seal(std::string_view bytes) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes.data(), bytes.size()));
    return {std::begin(canonical.digest), std::end(canonical.digest)};
}

bool isSealed(std::string_view entry) {
    const std::size_t length = sizeof(XXH128_canonical_t::digest);
    return entry.size() > length &&
           entry.substr(entry.size() - length) == seal(entry.substr(0, entry.size() - length));
}

/// "<32 hex>.exr. ...": what else a user keeps in the folder is not ours.
bool isOfAnEntry(std::string_view name) {
    constexpr std::size_t kKeyLength = 2 * sizeof(XXH128_canonical_t::digest);
    return name.find_first_not_of("0123456789abcdef") == kKeyLength &&
           name.substr(kKeyLength).starts_with(kExtension);
}

}  // namespace

ReferenceCache::ReferenceCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

std::filesystem::path ReferenceCache::defaultFolder() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    // The XDG base directory specification: relative paths are invalid and to be ignored.
    if (cache && std::filesystem::path(cache).is_absolute())
        return std::filesystem::path(cache) / "penumbra";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".cache" / "penumbra";
    return std::filesystem::temp_directory_path() / "penumbra-cache";
}

std::string ReferenceCache::key(const Geometry& geometry, const std::vector<Material>& materials,
                                const std::vector<TextureImage>& images, const GBuffer& gbuffer,
                                const AreaLight& light, const ReferenceOptions& options) {
    Hasher hasher;
    hasher.add(kAlgorithmVersion);
    hasher.add(options.targetStandardError);
    hasher.add(options.seed);
    hasher.add(options.adaptive);
    hasher.add(options.maxRaysPerPixel);
    for (const glm::dvec3& v : {light.centre, light.axisU, light.axisV}) hasher.add(v);
    hasher.add(light.halfU);
    hasher.add(light.halfV);
    hasher.add(gbuffer.width);
    hasher.add(gbuffer.height);
    hasher.add(gbuffer.position);
    hasher.add(gbuffer.geometricNormal);
    hasher.add(gbuffer.mask);
    hasher.add(gbuffer.irradianceUnshadowed);
    addCasters(hasher, geometry, materials, images);
    return hasher.hex();
}

std::filesystem::path ReferenceCache::entry(const std::string& key) const {
    return (folder_ / key).concat(kExtension);
}

std::optional<Reference> ReferenceCache::load(const std::string& key, int width, int height,
                                              std::string* damage) const {
    const std::filesystem::path path = entry(key);
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
    Reference reference;
    reference.width = width;
    reference.height = height;
    try {
        std::ifstream file(path, std::ios::binary);
        if (!isSealed(std::string(std::istreambuf_iterator<char>(file), {})))
            throw std::runtime_error("cut short, altered or of an earlier version");
        const Image image = readImage(path);
        if (image.width != width || image.height != height)
            throw std::runtime_error("of another size");
        for (const Channel& channel : kChannels)
            reference.*channel.values = image.channel(channel.name);
        for (const Channel& channel : kChannels)
            for (const float value : reference.*channel.values)
                if (!std::isfinite(value)) throw std::runtime_error("not finite");
    } catch (const std::exception& e) {
        if (damage) *damage = fmt::format("{}: {}", path.string(), e.what());
        return std::nullopt;
    }
    return reference;
}

void ReferenceCache::store(const std::string& key, const Reference& reference) const {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error)
        throw std::runtime_error("cache folder " + folder_.string() + ": " + error.message());
    removeStaleTemporaries(folder_, std::chrono::hours(1), isOfAnEntry);
    std::vector<std::string> names;
    for (const Channel& channel : kChannels) names.emplace_back(channel.name);
    Image image = Image::withChannels(reference.width, reference.height, std::move(names));
    for (const Channel& channel : kChannels)
        image.setChannel(channel.name, reference.*channel.values);
    std::string bytes = encodeExr(image);
    bytes += seal(bytes);
    writeFileAtomically(entry(key), bytes);
}

}  // namespace penumbra
