#include "roadgen/object/object.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <type_traits>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "roadgen/object/primitive.h"

namespace roadgen {
namespace {

// Below this part of the product of their lengths, axes count as parallel or in one plane.
constexpr double kLeastSine = 1e-9;
constexpr double kGreatest_m = 1e9, kLeast_m = 1e-9;

bool finite(double x) { return std::isfinite(x); }
bool finite(glm::dvec3 p) { return finite(p.x) && finite(p.y) && finite(p.z); }

// A length that a picture in single precision can be made of.
bool fits(double length_m) { return length_m >= kLeast_m && length_m <= kGreatest_m; }

using Fault = const char*;  // null: none

Fault check_numbers(std::initializer_list<glm::dvec3> points, std::initializer_list<double> numbers = {}) {
  const bool all = std::all_of(points.begin(), points.end(), [](glm::dvec3 p) { return finite(p); }) &&
                   std::all_of(numbers.begin(), numbers.end(), [](double x) { return finite(x); });
  return all ? nullptr : "a number is not finite";
}

Fault check_radius(double radius) {
  if (!(radius > 0)) return "the radius must be greater than 0";
  return fits(radius) ? nullptr : "the radius must lie in 1e-9 to 1e9 m";
}

Fault check_axes(glm::dvec3 u, glm::dvec3 v, Fault why) {
  const double size = glm::length(u) * glm::length(v);
  if (!fits(glm::length(u)) || !fits(glm::length(v))) return "an axis or edge must be 1e-9 to 1e9 m long";
  return glm::length(glm::cross(u, v)) > kLeastSine * size ? nullptr : why;
}

Fault check_axes(glm::dvec3 u, glm::dvec3 v, glm::dvec3 w, Fault why) {
  for (const glm::dvec3 axis : {u, v, w}) {
    if (!fits(glm::length(axis))) return "an axis or edge must be 1e-9 to 1e9 m long";
  }
  const double size = glm::length(u) * glm::length(v) * glm::length(w);
  return std::abs(glm::dot(glm::cross(u, v), w)) > kLeastSine * size ? nullptr : why;
}

Fault first(std::initializer_list<Fault> faults) {
  for (const Fault fault : faults) {
    if (fault) return fault;
  }
  return nullptr;
}

Fault fault_of(const Circle& s) {
  return first({check_numbers({s.center, s.normal}, {s.radius}), check_radius(s.radius),
                glm::length(s.normal) > 0 ? nullptr : "the normal must not be 0"});
}

Fault fault_of(const Ellipse& s) {
  return first({check_numbers({s.center, s.axis_u, s.axis_v}),
                check_axes(s.axis_u, s.axis_v, "the two axes must not be parallel")});
}

Fault fault_of(const Conic& s) {
  const auto& c = s.coefficients;
  if (const Fault fault = first({check_numbers({s.origin, s.axis_u, s.axis_v}, {c[0], c[1], c[2], c[3], c[4], c[5]}),
                                 check_numbers({{s.low, 0}, {s.high, 0}}),
                                 check_axes(s.axis_u, s.axis_v, "the two axes must not be parallel")})) {
    return fault;
  }
  if (!(s.low.x < s.high.x && s.low.y < s.high.y)) return "the bounds must have an extent: low < high";
  if (!fits(s.high.x - s.low.x) || !fits(s.high.y - s.low.y)) return "the bounds must be 1e-9 to 1e9 wide";
  const bool curve = std::any_of(c.begin(), c.begin() + 5, [](double x) { return x != 0; });
  return curve ? nullptr : "the conic's coefficients must not all be 0";
}

Fault fault_of(const Triangle& s) {
  return first({check_numbers({s.a, s.b, s.c}),
                check_axes(s.b - s.a, s.c - s.a, "the triangle is degenerate: its corners lie on one line")});
}

Fault fault_of(const Parallelogram& s) {
  return first({check_numbers({s.corner, s.edge_u, s.edge_v}),
                check_axes(s.edge_u, s.edge_v, "the two edges must not be parallel")});
}

Fault fault_of(const Sphere& s) { return first({check_numbers({s.center}, {s.radius}), check_radius(s.radius)}); }

Fault fault_of(const Ellipsoid& s) {
  return first({check_numbers({s.center, s.axis_x, s.axis_y, s.axis_z}),
                check_axes(s.axis_x, s.axis_y, s.axis_z, "the three axes must not lie in one plane")});
}

Fault fault_of(const Quadric& s) {
  for (const double c : s.coefficients) {
    if (!finite(c)) return "a number is not finite";
  }
  if (const Fault fault = check_numbers({s.box_low, s.box_high})) return fault;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(s.box_low[axis] < s.box_high[axis])) return "the box must have an extent: its low corner below its high one";
    if (!fits(s.box_high[axis] - s.box_low[axis])) return "the box must be 1e-9 to 1e9 m wide";
  }
  // In the frame of the box, where its size and place do not blur what is zero.
  switch (quadric_type(quadric_in_box(s))) {
    case QuadricType::kNothing: return "the quadric is singular: all its coefficients but the last are 0";
    case QuadricType::kImaginaryEllipsoid:
    case QuadricType::kImaginaryCylinder:
    case QuadricType::kImaginaryPlanes: return "the quadric has no real points";
    case QuadricType::kPoint: return "the quadric is singular: a single point, which nothing can be seen of";
    case QuadricType::kLine: return "the quadric is singular: a single line, which nothing can be seen of";
    default: return nullptr;
  }
}

Fault fault_of(const Cylinder& s) {
  return first({check_numbers({s.from, s.to}, {s.radius}), check_radius(s.radius),
                fits(glm::length(s.to - s.from)) ? nullptr : "the ends must be 1e-9 to 1e9 m apart"});
}

Fault fault_of(const Cone& s) {
  if (const Fault fault = check_numbers({s.from, s.to}, {s.radius_from, s.radius_to})) return fault;
  if (s.radius_from < 0 || s.radius_to < 0) return "the radii must not be negative";
  return first({check_radius(std::max(s.radius_from, s.radius_to)),
                fits(glm::length(s.to - s.from)) ? nullptr : "the ends must be 1e-9 to 1e9 m apart"});
}

Fault fault_of(const Parallelepiped& s) {
  return first({check_numbers({s.corner, s.edge_x, s.edge_y, s.edge_z}),
                check_axes(s.edge_x, s.edge_y, s.edge_z, "the three edges must not lie in one plane")});
}

Fault fault_of(const Tetrahedron& s) {
  return first(
      {check_numbers({s.a, s.b, s.c, s.d}),
       check_axes(s.b - s.a, s.c - s.a, s.d - s.a, "the tetrahedron is degenerate: its corners lie in one plane")});
}

Fault fault_of(const Torus& s) {
  return first({check_numbers({s.center, s.axis}, {s.major_radius, s.minor_radius}), check_radius(s.minor_radius),
                check_radius(s.major_radius), glm::length(s.axis) > 0 ? nullptr : "the axis must not be 0",
                s.minor_radius < s.major_radius ? nullptr : "the minor radius must be less than the major one"});
}

Fault fault_of_transform(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!finite(m[column][row])) return "a number of the transform is not finite";
    }
    if (m[column][3] != (column == 3 ? 1.0 : 0.0)) return "the transform must be affine: its last row 0 0 0 1";
  }
  return check_axes(m[0], m[1], m[2], "the transform is singular");
}

bool unit_range(float x) { return x >= 0 && x <= 1; }
bool unit_range(glm::vec3 c) { return unit_range(c.x) && unit_range(c.y) && unit_range(c.z); }

Fault fault_of(const ObjectMaterial& m) {
  if (!unit_range(m.base_color) || !unit_range(m.specular)) return "colours must lie in 0 to 1";
  if (!unit_range(m.metallic) || !unit_range(m.roughness)) return "metallic and roughness must lie in 0 to 1";
  if (!unit_range(m.reflection) || !unit_range(m.transmission)) return "reflection and transmission must lie in 0 to 1";
  if (!(m.shininess >= 1 && m.shininess <= 1e6f)) return "the shininess must lie in 1 to 1e6";
  return m.ior >= 1 && m.ior <= 4 ? nullptr : "the index of refraction must lie in 1 to 4";
}

std::string place(const char* kind, std::size_t index, const std::string& name) {
  return std::string(kind) + " " + std::to_string(index) + (name.empty() ? "" : " (" + name + ")");
}

}  // namespace

const char* shape_name(const Shape& shape) {
  static constexpr const char* kNames[] = {"circle",         "ellipse",     "conic",   "triangle", "parallelogram",
                                           "sphere",         "ellipsoid",   "quadric", "cylinder", "cone",
                                           "parallelepiped", "tetrahedron", "torus"};
  static_assert(std::size(kNames) == std::variant_size_v<Shape>);
  return kNames[shape.index()];
}

Tetrahedron regular_tetrahedron(glm::dvec3 apex, glm::dvec3 direction, double side) {
  const glm::dvec3 down = glm::normalize(direction);
  const glm::dvec3 aside =
      std::abs(down.z) > 0.999999 ? glm::dvec3(1, 0, 0) : glm::normalize(glm::cross(glm::dvec3(0, 0, 1), down));
  const glm::dvec3 ahead = glm::cross(down, aside);
  const glm::dvec3 base = apex + down * (side * std::sqrt(2.0 / 3));
  const double out = side / std::sqrt(3.0);
  return {apex, base + ahead * out, base - ahead * (0.5 * out) + aside * (0.5 * side),
          base - ahead * (0.5 * out) - aside * (0.5 * side)};
}

Result<Quadric> quadric_from_matrix(const glm::dmat4& m, glm::dvec3 box_low, glm::dvec3 box_high) {
  double greatest = 0;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) {
      if (!finite(m[i][k])) return Error{ErrorCode::kData, "a number of the quadric's matrix is not finite"};
      greatest = std::max(greatest, std::abs(m[i][k]));
    }
  }
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < i; ++k) {
      if (std::abs(m[i][k] - m[k][i]) > 1e-9 * greatest) {
        return Error{ErrorCode::kData, "the quadric's matrix must be symmetric: element " + std::to_string(k) + "," +
                                           std::to_string(i) + " is not element " + std::to_string(i) + "," +
                                           std::to_string(k)};
      }
    }
  }
  const auto twice = [&](int i, int k) { return m[i][k] + m[k][i]; };
  return Quadric{{m[0][0], m[1][1], m[2][2], twice(0, 1), twice(0, 2), twice(1, 2), twice(0, 3), twice(1, 3),
                  twice(2, 3), m[3][3]},
                 box_low,
                 box_high};
}

std::size_t ObjectScene::instances() const {
  std::size_t count = objects.size();
  for (const SphereSet& set : sphere_sets) count += set.items.size();
  return count;
}

Diagnostics check(const ObjectScene& scene, std::size_t most) {
  Diagnostics found;
  const auto report = [&](Fault fault, const std::string& element, const std::string& more = {}) {
    if (found.size() < most) found.push_back({Severity::kError, fault + more, {}, 0, element});
  };
  const std::size_t materials = std::max<std::size_t>(1, scene.materials.size());
  constexpr Fault kNoMaterial = "there is no material of this index: ";
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const ObjectMaterial& material = scene.materials[i];
    if (const Fault fault = fault_of(material)) report(fault, place("material", i, material.name));
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    const Fault fault = first({std::visit([](const auto& shape) { return fault_of(shape); }, object.shape),
                               fault_of_transform(object.transform)});
    if (fault) report(fault, place("object", i, object.name), std::string(" (") + shape_name(object.shape) + ")");
    if (object.material >= materials) {
      report(kNoMaterial, place("object", i, object.name), std::to_string(object.material));
    }
  }
  for (std::size_t i = 0; i < scene.sphere_sets.size(); ++i) {
    const SphereSet& set = scene.sphere_sets[i];
    const std::string element = place("sphere set", i, set.name);
    if (!finite(set.origin_m)) report("a number of the origin is not finite", element);
    if (set.material >= materials) report(kNoMaterial, element, std::to_string(set.material));
    for (std::size_t k = 0; k < set.items.size() && found.size() < most; ++k) {
      const SphereSet::Item& item = set.items[k];
      const Fault fault = first({check_numbers({glm::dvec3(item.center)}, {item.radius}), check_radius(item.radius)});
      if (fault) report(fault, element, ": sphere " + std::to_string(k));
    }
  }
  return found;
}

}  // namespace roadgen
