// Internal: one shape or material of a scene file from its JSON.
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <string_view>

#include "roadgen/import/json_stream.h"
#include "roadgen/object/object.h"

namespace roadgen {

// The keys that any object of a scene may have.
inline constexpr std::array<std::string_view, 6> kObjectKeys = {"type",      "name",  "material",
                                                                "transform", "place", "instances"};

// That the object has no keys but kObjectKeys and these.
Status expect_object_keys(const JsonNode& node, std::initializer_list<std::string_view> keys);

// Errors: kData, kParse, also for a type that is no shape.
Result<Shape> read_shape(const std::string& type, const JsonNode& node);

// folder: from which the texture's file is sought.
Result<ObjectMaterial> read_material(const std::string& name, const JsonNode& node, const std::string& folder);

// Row-major 4 by 4. Errors: also where it is not affine.
Result<glm::dmat4> read_transform(const JsonNode& node);

// Of text for a message: at most 60 bytes.
inline std::string quoted(const std::string& text) {
  return "'" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "'";
}

}  // namespace roadgen
