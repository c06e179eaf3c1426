#include "roadgen/import/scene_shapes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

namespace roadgen {
namespace {

// Reads the members of an object; after the first fault the rest are 0.
class Fields {
 public:
  explicit Fields(const JsonNode& node) : node_(node) {}

  bool has(std::string_view key) const { return node_.has(key); }
  double number(std::string_view key) {
    double x = 0;
    take(key, [&](const JsonNode& n) { return set(x, n.number()); });
    return x;
  }
  double number(std::string_view key, double otherwise) { return has(key) ? number(key) : otherwise; }
  bool truth(std::string_view key, bool otherwise) {
    bool x = otherwise;
    if (has(key)) take(key, [&](const JsonNode& n) { return set(x, n.truth()); });
    return x;
  }
  template <std::size_t N>
  std::array<double, N> numbers(std::string_view key) {
    std::array<double, N> x{};
    take(key, [&](const JsonNode& n) { return n.numbers(x.data(), N); });
    return x;
  }
  glm::dvec3 point(std::string_view key) {
    const auto x = numbers<3>(key);
    return {x[0], x[1], x[2]};
  }
  glm::dvec3 point(std::string_view key, glm::dvec3 otherwise) { return has(key) ? point(key) : otherwise; }
  glm::dvec2 pair(std::string_view key, glm::dvec2 otherwise) {
    if (!has(key)) return otherwise;
    const auto x = numbers<2>(key);
    return {x[0], x[1]};
  }
  // An array of N points.
  template <std::size_t N>
  std::array<glm::dvec3, N> points(std::string_view key) {
    std::array<glm::dvec3, N> found{};
    take(key, [&](const JsonNode& n) -> Status {
      if (Status s = n.expect(JsonValue::Kind::kArray); !s) return s;
      if (n.value().items.size() != N) {
        return n.error("expected " + std::to_string(N) + " points, found " + std::to_string(n.value().items.size()));
      }
      for (std::size_t i = 0; i < N; ++i) {
        if (Status s = n.item(i).numbers(&found[i].x, 3); !s) return s;
      }
      return Done{};
    });
    return found;
  }

  // The first fault, or the shape.
  Result<Shape> result(Shape shape) const {
    if (error_) return *error_;
    return shape;
  }

  template <class Read>
  void take(std::string_view key, Read&& read) {
    if (error_) return;
    const auto found = node_.at(key);
    if (!found) {
      error_ = found.error();
    } else if (Status s = read(*found); !s) {
      error_ = s.error();
    }
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  template <class T>
  static Status set(T& x, Result<T> found) {
    if (!found) return found.error();
    x = std::move(*found);
    return Done{};
  }

  const JsonNode& node_;
  std::optional<Error> error_;
};

using Keys = std::initializer_list<std::string_view>;

Result<Shape> circle(const JsonNode& node) {
  Fields f(node);
  return f.result(Circle{f.point("center"), f.point("normal", {0, 0, 1}), f.number("radius")});
}

Result<Shape> ellipse(const JsonNode& node) {
  Fields f(node);
  return f.result(Ellipse{f.point("center"), f.point("axis_u"), f.point("axis_v")});
}

Result<Shape> conic(const JsonNode& node) {
  Fields f(node);
  Conic shape{f.point("origin"), f.point("axis_u"), f.point("axis_v")};
  shape.coefficients = f.numbers<6>("coefficients");
  shape.low = f.pair("low", shape.low);
  shape.high = f.pair("high", shape.high);
  return f.result(shape);
}

Result<Shape> triangle(const JsonNode& node) {
  Fields f(node);
  const auto v = f.points<3>("vertices");
  return f.result(Triangle{v[0], v[1], v[2]});
}

Result<Shape> parallelogram(const JsonNode& node) {
  Fields f(node);
  return f.result(Parallelogram{f.point("corner"), f.point("edge_u"), f.point("edge_v")});
}

Result<Shape> sphere(const JsonNode& node) {
  Fields f(node);
  return f.result(Sphere{f.point("center"), f.number("radius")});
}

Result<Shape> ellipsoid(const JsonNode& node) {
  Fields f(node);
  Ellipsoid shape{f.point("center")};
  if (f.has("radii")) {
    const glm::dvec3 r = f.point("radii");
    shape.axis_x = {r.x, 0, 0}, shape.axis_y = {0, r.y, 0}, shape.axis_z = {0, 0, r.z};
    if (!(r.x > 0 && r.y > 0 && r.z > 0) && !f.error())
      return node.at("radii")->error("the radii must be greater than 0");
  } else {
    const auto axes = f.points<3>("axes");
    shape.axis_x = axes[0], shape.axis_y = axes[1], shape.axis_z = axes[2];
  }
  return f.result(shape);
}

Result<Shape> quadric(const JsonNode& node) {
  Fields f(node);
  Quadric shape;
  const auto box = f.points<2>("box");
  if (f.has("matrix")) {
    glm::dmat4 matrix(0);
    f.take("matrix", [&](const JsonNode& n) -> Status {
      if (Status s = n.expect(JsonValue::Kind::kArray); !s) return s;
      if (n.value().items.size() != 4) return n.error("expected 4 rows of 4 numbers");
      for (int i = 0; i < 4; ++i) {
        if (Status s = n.item(static_cast<std::size_t>(i)).numbers(&matrix[i].x, 4); !s) return s;
      }
      const auto read = quadric_from_matrix(matrix, box[0], box[1]);
      if (!read) return n.error(read.error().message);
      shape = *read;
      return Done{};
    });
  } else {
    shape.coefficients = f.numbers<10>("coefficients");
  }
  shape.box_low = box[0], shape.box_high = box[1];
  shape.solid = f.truth("solid", false);
  return f.result(shape);
}

Result<Shape> cylinder(const JsonNode& node) {
  Fields f(node);
  return f.result(Cylinder{f.point("from"), f.point("to"), f.number("radius")});
}

Result<Shape> cone(const JsonNode& node) {
  Fields f(node);
  return f.result(Cone{f.point("from"), f.point("to"), f.number("radius_from"), f.number("radius_to", 0)});
}

Result<Shape> box(const JsonNode& node) {
  Fields f(node);
  const glm::dvec3 low = f.point("low"), high = f.point("high"), size = high - low;
  if (!(size.x > 0 && size.y > 0 && size.z > 0) && !f.error()) {
    return node.error("the box must have an extent: each number of 'low' below that of 'high'");
  }
  return f.result(Parallelepiped{low, {size.x, 0, 0}, {0, size.y, 0}, {0, 0, size.z}});
}

Result<Shape> parallelepiped(const JsonNode& node) {
  Fields f(node);
  const glm::dvec3 corner = f.point("corner");
  const auto edges = f.points<3>("edges");
  return f.result(Parallelepiped{corner, edges[0], edges[1], edges[2]});
}

Result<Shape> tetrahedron(const JsonNode& node) {
  Fields f(node);
  if (!f.has("apex")) {
    const auto v = f.points<4>("vertices");
    return f.result(Tetrahedron{v[0], v[1], v[2], v[3]});
  }
  const glm::dvec3 apex = f.point("apex"), direction = f.point("direction");
  const double side = f.number("side");
  if (f.error()) return *f.error();
  if (!(glm::dot(direction, direction) > 0)) return node.at("direction")->error("the direction must not be 0");
  if (!(side > 0)) return node.at("side")->error("the side must be greater than 0");
  return Shape(regular_tetrahedron(apex, direction, side));
}

Result<Shape> torus(const JsonNode& node) {
  Fields f(node);
  return f.result(
      Torus{f.point("center"), f.point("axis", {0, 0, 1}), f.number("major_radius"), f.number("minor_radius")});
}

struct ShapeReader {
  std::string_view type;
  Keys keys;
  Result<Shape> (*read)(const JsonNode&);
};
const ShapeReader kReaders[] = {
    {"circle", {"center", "normal", "radius"}, circle},
    {"ellipse", {"center", "axis_u", "axis_v"}, ellipse},
    {"conic", {"origin", "axis_u", "axis_v", "coefficients", "low", "high"}, conic},
    {"triangle", {"vertices"}, triangle},
    {"parallelogram", {"corner", "edge_u", "edge_v"}, parallelogram},
    {"sphere", {"center", "radius"}, sphere},
    {"ellipsoid", {"center", "radii", "axes"}, ellipsoid},
    {"quadric", {"coefficients", "matrix", "box", "solid"}, quadric},
    {"cylinder", {"from", "to", "radius"}, cylinder},
    {"cone", {"from", "to", "radius_from", "radius_to"}, cone},
    {"box", {"low", "high"}, box},
    {"parallelepiped", {"corner", "edges"}, parallelepiped},
    {"tetrahedron", {"vertices", "apex", "direction", "side"}, tetrahedron},
    {"torus", {"center", "axis", "major_radius", "minor_radius"}, torus},
};

double linear(int srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

// [r, g, b], linear, or "#rrggbb", sRGB.
Status read_color(const JsonNode& node, glm::vec3& color) {
  if (node.value().kind != JsonValue::Kind::kString) {
    double c[3];
    if (Status s = node.numbers(c, 3); !s) return s;
    color = {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
    return Done{};
  }
  const std::string& text = node.value().text;
  unsigned code = 0;
  const char* const end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, code, 16).ptr != end) {
    return node.error("a colour is [r, g, b] in linear light or \"#rrggbb\"");
  }
  for (int i = 0; i < 3; ++i) color[i] = static_cast<float>(linear(static_cast<int>(code >> (16 - 8 * i) & 0xFF)));
  return Done{};
}

}  // namespace

Status expect_object_keys(const JsonNode& node, Keys keys) {
  std::vector<std::string_view> known(keys);
  known.insert(known.end(), kObjectKeys.begin(), kObjectKeys.end());
  for (const auto& [key, value] : node.value().members) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string names;
    for (const std::string_view name : known) names += (names.empty() ? "" : ", ") + std::string(name);
    return node.at(key)->error("unknown key; known here: " + names);
  }
  return Done{};
}

Result<Shape> read_shape(const std::string& type, const JsonNode& node) {
  for (const ShapeReader& reader : kReaders) {
    if (reader.type != type) continue;
    if (Status s = expect_object_keys(node, reader.keys); !s) return s.error();
    return reader.read(node);
  }
  std::string names;
  for (const ShapeReader& reader : kReaders) names += std::string(reader.type) + ", ";
  return node.at("type")->error("unknown type " + quoted(type) + "; known are " + names + "spheres, group");
}

Result<ObjectMaterial> read_material(const std::string& name, const JsonNode& node, const std::string& folder) {
  if (Status s = node.expect_keys({"model", "base_color", "metallic", "roughness", "specular", "shininess",
                                   "reflection", "transmission", "ior", "texture"});
      !s) {
    return s.error();
  }
  ObjectMaterial material;
  material.name = name;
  Fields f(node);
  if (node.has("model")) {
    f.take("model", [&](const JsonNode& n) -> Status {
      const auto model = n.text();
      if (!model) return model.error();
      if (*model != "metal-roughness" && *model != "phong") return n.error("the models are metal-roughness and phong");
      material.model = *model == "phong" ? ObjectMaterial::Model::kPhong : ObjectMaterial::Model::kMetalRoughness;
      return Done{};
    });
  }
  const auto color = [&](std::string_view key, glm::vec3& to) {
    if (node.has(key)) f.take(key, [&](const JsonNode& n) { return read_color(n, to); });
  };
  color("base_color", material.base_color);
  color("specular", material.specular);
  const auto number = [&](std::string_view key, float& to) { to = static_cast<float>(f.number(key, to)); };
  number("metallic", material.metallic);
  number("roughness", material.roughness);
  number("shininess", material.shininess);
  number("reflection", material.reflection);
  number("transmission", material.transmission);
  number("ior", material.ior);
  if (node.has("texture")) {
    f.take("texture", [&](const JsonNode& n) -> Status {
      const auto file = n.text();
      if (!file) return file.error();
      if (file->empty()) return n.error("the name of the texture's file is empty");
      material.texture_file = (std::filesystem::path(folder) / *file).string();
      return Done{};
    });
  }
  if (f.error()) return *f.error();
  // What the object library has to say about its numbers.
  const Diagnostics faults = check(ObjectScene{{}, {}, {material}}, 1);
  if (!faults.empty()) return node.error(faults.front().message);
  return material;
}

Result<glm::dmat4> read_transform(const JsonNode& node) {
  if (Status s = node.expect(JsonValue::Kind::kArray); !s) return s.error();
  std::array<double, 16> x{};
  if (node.value().items.size() == 4) {
    for (std::size_t row = 0; row < 4; ++row) {
      if (Status s = node.item(row).numbers(&x[4 * row], 4); !s) return s.error();
    }
  } else if (Status s = node.numbers(x.data(), 16); !s) {
    return node.value().items.size() == 16 ? s.error()
                                           : node.error("expected 16 numbers, row by row, or 4 rows of 4 numbers");
  }
  glm::dmat4 map;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) map[column][row] = x[static_cast<std::size_t>(4 * row + column)];
  }
  if (map[0][3] != 0 || map[1][3] != 0 || map[2][3] != 0 || map[3][3] != 1) {
    return node.error("the transform must be affine: its last row 0, 0, 0, 1");
  }
  return map;
}

}  // namespace roadgen
