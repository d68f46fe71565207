#include "core/scene/procedural_asset.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/sampling/sampling.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr const char* kPrefix = "procedural:";
constexpr const char* kLandscape = "procedural:landscape:";
constexpr double kSideM = 20.0;
constexpr std::uint32_t kToriAcross = 10;
constexpr std::uint32_t kPebbleNodes = 64;  ///< parts into which the pebbles are put

/// Height of the ground and, by its slopes, its normal: smooth, and the same for any tessellation.
struct Ground {
    double heightM;
    glm::dvec3 normal;
    static Ground at(double xM, double zM) {
        struct Wave {
            double x, z, phase, heightM;
        };
        constexpr Wave kWaves[] = {{0.45, 0.31, 0.3, 0.45},
                                   {-0.38, 0.71, 1.9, 0.3},
                                   {1.3, -0.9, 4.1, 0.12},
                                   {2.9, 2.3, 2.2, 0.03}};
        double height = 0.0, slopeX = 0.0, slopeZ = 0.0;
        for (const Wave& w : kWaves) {
            const double angle = w.x * xM + w.z * zM + w.phase;
            height += w.heightM * std::sin(angle);
            slopeX += w.heightM * w.x * std::cos(angle);
            slopeZ += w.heightM * w.z * std::cos(angle);
        }
        return {height, glm::normalize(glm::dvec3(-slopeX, 1.0, -slopeZ))};
    }
};

double unit(std::uint32_t of, std::uint32_t index, std::uint32_t axis) {
    return toUnitFloat(hash(of, index, axis));
}

/// Vertices on a grid of `columns` x `rows` quads, made by `place(column, row)`; a direction that
/// closes on itself has no vertices of its own at its end.
template <class Place>
AssetPrimitive gridOf(std::uint32_t columns, std::uint32_t rows, bool closed, const Place& place) {
    const std::uint32_t across = columns + !closed, down = rows + !closed;
    AssetPrimitive out;
    const std::size_t vertices = std::size_t{across} * down;
    out.positions.resize(vertices);
    out.normals.resize(vertices);
    out.uvs.assign(vertices, glm::vec2(0.0f));
    out.indices.resize(std::size_t{6} * columns * rows);
    tbb::parallel_for(std::uint32_t{0}, down, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < across; ++column) {
            const auto [position, normal] = place(column, row);
            const std::size_t i = std::size_t{row} * across + column;
            out.positions[i] = glm::vec3(position);
            out.normals[i] = glm::vec3(normal);
        }
    });
    tbb::parallel_for(std::uint32_t{0}, rows, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const auto vertex = [&](std::uint32_t c, std::uint32_t r) {
                return (r % down) * across + c % across;
            };
            const std::uint32_t a = vertex(column, row), b = vertex(column, row + 1),
                                c = vertex(column + 1, row + 1), d = vertex(column + 1, row);
            const std::uint32_t corners[] = {a, b, c, a, c, d};
            std::copy_n(corners, 6, &out.indices[std::size_t{6} * (row * columns + column)]);
        }
    });
    return out;
}

AssetPrimitive ground(std::uint32_t quads) {
    return gridOf(quads, quads, false, [&](std::uint32_t column, std::uint32_t row) {
        const double x = kSideM * (static_cast<double>(column) / quads - 0.5);
        const double z = kSideM * (static_cast<double>(row) / quads - 0.5);
        const Ground here = Ground::at(x, z);
        return std::pair(glm::dvec3(x, here.heightM, z), here.normal);
    });
}

AssetPrimitive torus(std::uint32_t quads) {
    constexpr double kRadiusM = 0.5, kTubeM = 0.16;
    return gridOf(quads, quads, true, [&](std::uint32_t column, std::uint32_t row) {
        const double turn = 2.0 * std::numbers::pi / quads;
        const double around = turn * column, tube = turn * row;
        const glm::dvec3 out(std::cos(around), 0.0, std::sin(around));
        const glm::dvec3 normal = std::cos(tube) * out + glm::dvec3(0, std::sin(tube), 0);
        return std::pair(kRadiusM * out + kTubeM * normal, normal);
    });
}

/// An octahedron of unit radius.
AssetPrimitive pebble() {
    AssetPrimitive out;
    out.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    out.normals = out.positions;
    out.uvs.assign(6, glm::vec2(0.0f));
    out.indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    return out;
}

}  // namespace

std::optional<ProceduralAsset> ProceduralAsset::parsed(const std::string& text) {
    if (!text.starts_with(kPrefix)) return std::nullopt;
    ProceduralAsset out;
    const std::string_view form(kLandscape);
    const char* const end = text.data() + text.size();
    const char* const number = text.data() + std::min(form.size(), text.size());
    const auto [stop, error] = std::from_chars(number, end, out.triangles);
    if (!text.starts_with(form) || error != std::errc() || stop != end ||
        out.triangles < kFewestTriangles || out.triangles > kMaxTriangles)
        throw std::invalid_argument(
            fmt::format("procedural: is followed by landscape:TRIANGLES, {} to {} of them",
                        kFewestTriangles, kMaxTriangles));
    return out;
}

Asset ProceduralAsset::make(const std::filesystem::path& file, const LoadOptions& options) const {
    const auto sideOf = [](std::size_t halfTriangles) {
        return static_cast<std::uint32_t>(std::sqrt(static_cast<double>(halfTriangles)));
    };
    const std::size_t tori = std::size_t{kToriAcross} * kToriAcross;
    const std::uint32_t groundQuads = sideOf(triangles / 4);
    const std::uint32_t torusQuads = sideOf(triangles / (8 * tori));
    const std::size_t left =
        triangles - std::size_t{2} * groundQuads * groundQuads - 2 * tori * torusQuads * torusQuads;
    const auto pebbles = static_cast<std::uint32_t>(left / 8);

    Asset out;
    out.file = file;
    out.memory = MemoryBudget(file, options.maxMemoryBytes);
    const std::size_t quads =
        std::size_t{groundQuads + 1} * (groundQuads + 1) + std::size_t{torusQuads} * torusQuads;
    out.memory.charge(quads, 2 * sizeof(glm::vec3) + sizeof(glm::vec2) + 6 * sizeof(std::uint32_t),
                      "", "its meshes");
    out.memory.charge(pebbles, sizeof(glm::dmat4), "", "its pebbles");

    const auto add = [&](const std::string& name, int primitive,
                         const glm::dvec3& at) -> Placement& {
        AssetNode node;
        node.name = name;
        node.transform.translation = at;
        out.nodes.push_back(std::move(node));
        out.placements.push_back({name, static_cast<int>(out.nodes.size()) - 1, primitive});
        return out.placements.back();
    };
    constexpr glm::vec3 kColours[] = {
        {0.55f, 0.6f, 0.45f}, {0.7f, 0.3f, 0.2f}, {0.6f, 0.6f, 0.62f}};
    const char* const names[] = {"ground", "tori", "pebbles"};
    for (int i = 0; i < 3; ++i)
        out.materials.push_back(
            Material{.name = names[i], .baseColor = glm::vec4(kColours[i], 1.0f)});
    out.emissions.assign(out.materials.size(), 0.0);
    out.primitives.push_back(ground(groundQuads));
    out.primitives.push_back(torus(torusQuads));
    out.primitives.push_back(pebble());
    for (int i = 0; i < 3; ++i) out.primitives[static_cast<std::size_t>(i)].material = i;

    add("ground", 0, glm::dvec3(0.0));
    for (std::uint32_t i = 0; i < tori; ++i) {
        const double cellM = kSideM / kToriAcross;
        const auto coordinate = [&](std::uint32_t cell, std::uint32_t axis) {
            return cellM * (cell + 0.3 + 0.4 * unit(1, i, axis)) - 0.5 * kSideM;
        };
        const double x = coordinate(i % kToriAcross, 0), z = coordinate(i / kToriAcross, 1);
        add(fmt::format("torus {}", i + 1), 1,
            {x, Ground::at(x, z).heightM + 0.3 + 0.9 * unit(1, i, 2), z});
        glm::dquat& rotation = out.nodes.back().transform.rotation;
        rotation = glm::angleAxis(std::numbers::pi * unit(1, i, 3),
                                  glm::normalize(glm::dvec3(1.0, 0.3, unit(1, i, 4))));
    }
    // On a jittered grid, each about a fifth of its cell wide.
    const auto across = static_cast<std::uint32_t>(std::ceil(std::sqrt(double{1.0} * pebbles)));
    const double cellM = kSideM / across;
    for (std::uint32_t part = 0; part < kPebbleNodes; ++part) {
        const auto first = static_cast<std::uint32_t>(std::uint64_t{pebbles} * part / kPebbleNodes);
        const auto end =
            static_cast<std::uint32_t>(std::uint64_t{pebbles} * (part + 1) / kPebbleNodes);
        add(fmt::format("pebbles {}", part + 1), 2, glm::dvec3(0.0)).instances =
            static_cast<int>(part);
        std::vector<glm::dmat4>& instances = out.instances.emplace_back();
        instances.reserve(end - first);
        for (std::uint32_t i = first; i < end; ++i) {
            const auto coordinate = [&](std::uint32_t cell, std::uint32_t axis) {
                return cellM * (cell + 0.2 + 0.6 * unit(2, i, axis)) - 0.5 * kSideM;
            };
            const double x = coordinate(i % across, 0), z = coordinate(i / across, 1);
            const double radiusM = cellM * (0.08 + 0.06 * unit(2, i, 2));
            glm::dmat4 matrix(radiusM);
            matrix[3] = {x, Ground::at(x, z).heightM + 0.6 * radiusM, z, 1.0};
            instances.push_back(matrix);
        }
    }
    return out;
}

}  // namespace penumbra::scene_detail
