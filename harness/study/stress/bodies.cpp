#include "harness/study/stress/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/sampling/sampling.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::stress {
namespace {

constexpr double kMostCopies = 1'000'000;

glm::dvec3 point(const Body& body, const char* key) {
    const std::vector<double>& n = body.numbers.at(key);
    return {n[0], n[1], n[2]};
}

double number(const Body& body, const char* key) {
    return body.numbers.at(key)[0];
}

/// A count of `key`, from 1 to `most`.
int count(const Body& body, const char* key, double most) {
    const double n = number(body, key);
    if (!(n >= 1.0 && n <= most))
        throw InputError(fmt::format("{}.{} must be 1 to {:.0f}", body.kind, key, most));
    return static_cast<int>(n);
}

void addQuad(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, Shape& shape) {
    shape.quad(corner, corner + u, corner + u + v, corner + v);
}

void box(const Body& body, Shape& shape) {
    shape.box(point(body, "lo"), point(body, "hi"));
}

void openBox(const Body& body, Shape& shape) {
    const glm::dvec3 lo = point(body, "lo"), size = point(body, "hi") - lo;
    const glm::dvec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
    addQuad(lo, x, y, shape);
    addQuad(lo + z, x, y, shape);
    addQuad(lo, z, y, shape);
    addQuad(lo + x, z, y, shape);
    addQuad(lo + y, x, z, shape);
}

void quad(const Body& body, Shape& shape) {
    addQuad(point(body, "corner"), point(body, "edge_u"), point(body, "edge_v"), shape);
}

void pile(const Body& body, Shape& shape) {
    const int copies = count(body, "copies", kMostCopies);
    for (int i = 0; i < copies; ++i) quad(body, shape);
}

void grid(const Body& body, Shape& shape) {
    shape.grid(point(body, "corner"), point(body, "edge_u"), point(body, "edge_v"),
               count(body, "cells", 1000));
}

void fan(const Body& body, Shape& shape) {
    const glm::dvec3 foot = point(body, "foot"), axis = point(body, "axis");
    const int leaves = count(body, "leaves", 1000);
    const glm::dvec3 up = glm::normalize(axis);
    const glm::dvec3 u = glm::normalize(
        glm::cross(up, std::abs(up.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 v = glm::cross(up, u);
    for (int i = 0; i < leaves; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / leaves;
        addQuad(foot, axis, number(body, "width") * (std::cos(angle) * u + std::sin(angle) * v),
                shape);
    }
}

void triangle(const Body& body, Shape& shape) {
    shape.triangle(point(body, "a"), point(body, "b"), point(body, "c"));
}

void sphere(const Body& body, Shape& shape) {
    shape.sphere(point(body, "centre"), number(body, "radius"), count(body, "rings", 500));
}

void shards(const Body& body, Shape& shape) {
    const glm::dvec3 lo = point(body, "lo"), size = point(body, "hi") - lo;
    const int copies = count(body, "copies", kMostCopies);
    const auto seed = static_cast<std::uint32_t>(number(body, "seed"));
    const auto unit = [&](int i, int j) {
        return glm::dvec3(toUnitFloat(hash(seed, i, j, 0)), toUnitFloat(hash(seed, i, j, 1)),
                          toUnitFloat(hash(seed, i, j, 2)));
    };
    for (int i = 0; i < copies; ++i) {
        const glm::dvec3 from = lo + unit(i, 0) * size, to = lo + unit(i, 1) * size;
        shape.triangle(from, to, 0.5 * (from + to) + number(body, "width") * (unit(i, 2) - 0.5));
    }
}

void wires(const Body& body, Shape& shape) {
    const glm::dvec3 from = point(body, "from"), along = point(body, "along");
    const glm::dvec3 step = point(body, "step");
    const glm::dvec3 across = number(body, "width") * glm::normalize(step);
    const int copies = count(body, "copies", 10'000);
    for (int i = 0; i < copies; ++i)
        addQuad(from + static_cast<double>(i) * step - 0.5 * across, along, across, shape);
}

}  // namespace

const std::vector<BodyKind>& bodyKinds() {
    const std::vector<BodyNumber> rectangle = {{"corner"}, {"edge_u"}, {"edge_v"}};
    const auto with = [](std::vector<BodyNumber> numbers, const BodyNumber& more) {
        numbers.push_back(more);
        return numbers;
    };
    static const std::vector<BodyKind> kinds = {
        {"box", "a closed box", {{"lo"}, {"hi"}}, box},
        {"open_box", "a box without its lower side (y)", {{"lo"}, {"hi"}}, openBox},
        {"quad", "two triangles", rectangle, quad},
        {"pile", "so many copies of a quad in one place", with(rectangle, {"copies", 1}), pile},
        {"grid", "a quad of cells x cells x 2 triangles", with(rectangle, {"cells", 1}), grid},
        {"triangle", "one triangle, of any shape", {{"a"}, {"b"}, {"c"}}, triangle},
        {"sphere",
         "a closed body of rings x 2 rings quads",
         {{"centre"}, {"radius", 1}, {"rings", 1, {8}}},
         sphere},
        {"fan",
         "quads that share one edge, from `foot` along `axis`, like a book's leaves",
         {{"foot"}, {"axis"}, {"width", 1}, {"leaves", 1}},
         fan},
        {"wires",
         "quads from `from` along `along`, each `step` from the last, `width` across",
         {{"from"}, {"along"}, {"step"}, {"width", 1}, {"copies", 1, {1}}},
         wires},
        {"shards",
         "triangles from place to place in lo..hi, drawn at random, some `width` wide",
         {{"lo"}, {"hi"}, {"width", 1}, {"copies", 1}, {"seed", 1, {1}}},
         shards},
    };
    return kinds;
}

const BodyKind& findBodyKind(const std::string& id) {
    std::vector<std::string> ids;
    for (const BodyKind& kind : bodyKinds()) {
        if (kind.id == id) return kind;
        ids.push_back(kind.id);
    }
    throw InputError(fmt::format("unknown kind of body '{}'; there are {}",
                                 scene_detail::oneLine(id, 60), scene_detail::listed(ids)));
}

Shape shapeOf(const Body& body) {
    Shape shape;
    findBodyKind(body.kind).add(body, shape);
    return shape;
}

}  // namespace penumbra::stress
