// The Stanford bunny as Debian's glmark2-data carries it: a Wavefront file of positions and
// triangles.
#include <filesystem>
#include <fstream>

#include "scenes/assets/asset.hpp"

namespace penumbra::assets {
namespace {

constexpr const char* kSource = "/usr/share/glmark2/models/bunny.obj";
constexpr float kHeightM = 1.5f;

Shape readObj(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) {
        throw SourceAbsent(file.string() + " is missing (Debian package glmark2-data)");
    }
    Shape shape;
    std::string keyword;
    while (stream >> keyword) {
        if (keyword == "v") {
            glm::vec3 p(0.0f);
            stream >> p.x >> p.y >> p.z;
            shape.addVertex(p);
        } else if (keyword == "f") {
            std::uint32_t a = 0, b = 0, c = 0;
            stream >> a >> b >> c;
            shape.addTriangle(a - 1, b - 1, c - 1);
        } else {
            std::getline(stream, keyword);
        }
        if (!stream) throw std::runtime_error(file.string() + ": not the expected Wavefront file");
    }
    for (const std::uint32_t index : shape.indices) {
        if (index >= shape.positions.size()) {
            throw std::runtime_error(file.string() + ": a face names a vertex that is not there");
        }
    }
    return shape;
}

void bunny(Asset& asset) {
    Shape shape = readObj(kSource);
    glm::vec3 lo = shape.positions.front(), hi = lo;
    for (const glm::vec3& position : shape.positions) {
        lo = glm::min(lo, position);
        hi = glm::max(hi, position);
    }
    const glm::vec3 foot(0.5f * (lo.x + hi.x), lo.y, 0.5f * (lo.z + hi.z));
    const float scale = kHeightM / (hi.y - lo.y);
    for (glm::vec3& position : shape.positions) position = scale * (position - foot);
    asset.addGround(7.0f, 7.0f);
    const int clay = asset.addMaterial({.name = "clay", .color = {0.65f, 0.45f, 0.35f}});
    asset.place("bunny", shape, clay, 80.0f);
}

const Register kBunny{"bunny", bunny};

}  // namespace
}  // namespace penumbra::assets
