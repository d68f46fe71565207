#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/scene/shape.hpp"

namespace penumbra::stress {

/// Something in a small scene: the name of a kind of body and its numbers, metres unless the kind
/// says otherwise. Plain data, so that case files, random draws and shrinking speak one language.
struct Body {
    std::string kind;
    std::map<std::string, std::vector<double>> numbers;
    bool operator==(const Body&) const = default;
};

/// One number, or list of numbers, of a kind of body.
struct BodyNumber {
    std::string key;
    std::size_t count = 3;
    std::vector<double> fallback = {};  ///< empty: must be given
};

struct BodyKind {
    std::string id;
    std::string doc;
    std::vector<BodyNumber> numbers;
    void (*add)(const Body&, Shape&);
};

/// Every kind of body there is.
const std::vector<BodyKind>& bodyKinds();
/// Throws InputError with the kinds that there are.
const BodyKind& findBodyKind(const std::string& id);

/// The triangles of `body`, whose numbers are complete. Throws InputError for a number that the
/// kind cannot take.
Shape shapeOf(const Body& body);

}  // namespace penumbra::stress
