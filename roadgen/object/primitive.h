// The kinds of primitives that all shapes are drawn as, one table row each, and what a shape is in its own frame.
//
// Algorithm 1 of the paper as an interface: a primitive is the functions NAME_value, NAME_hits, NAME_normal, NAME_uv and
// those of its proxy in a file of shaders/lib (object.glsl says what each does), and a row of primitive_table(). The
// renderer makes its program from the name, the CPU's rays call the same functions in double.
#pragma once

#include <array>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/object/object.h"
#include "shaders/lib/glsl.h"

namespace roadgen {

using ObjectLib = glsl::Library<double>;

enum class PrimitiveKind { kSphere, kQuadric, kCone, kBox, kTetra, kTorus, kDisc, kConic, kTriangle, kRhomb };

// What is drawn to cover a primitive on the screen. Hulls are drawn by their back faces, so that the eye may be inside.
enum class Proxy {
  kOutline,   // a polygon around what the eye sees, NAME_outline; of the unit sphere algorithm 3 of the paper
  kRing,      // NAME_outline's polygon but for the one within its hole
  kHull,      // a convex polyhedron around the quadric, each its own: quadric_hull()
  kBox,       // [-1, 1]^3 through NAME_proxy
  kTetra,     // the corners of tetra
  kPolygon,   // a polygon around the unit circle in z = 0
  kTriangle,  // the corners of triangle
  kSquare,    // [-1, 1]^2 in z = 0
};

struct PrimitiveRow {
  PrimitiveKind kind;
  const char* name;  // the functions' prefix in shaders/lib
  Proxy proxy;
  bool flat;    // lies in z = 0
  bool at_eye;  // its hits use its value at the ray's origin: NAME_at_eye in shaders/object.vert gives it in double
  double (*value)(glm::dvec3 p, const ObjectLib::ObjectShape& shape);
  ObjectLib::ObjectHits (*hits)(glm::dvec3 o, glm::dvec3 d, double at_o, const ObjectLib::ObjectShape& shape);
  glm::dvec3 (*normal)(glm::dvec3 p, int face, const ObjectLib::ObjectShape& shape);
  glm::dvec2 (*uv)(glm::dvec3 p, int face, const ObjectLib::ObjectShape& shape);
};
// Row i is of kind i.
std::span<const PrimitiveRow> primitive_table();
inline const PrimitiveRow& primitive_row(PrimitiveKind kind) {
  return primitive_table()[static_cast<std::size_t>(kind)];
}

// A shape in its own frame: p_world = center_m + axes p, about unit size.
struct Primitive {
  PrimitiveKind kind = PrimitiveKind::kSphere;
  glm::dvec3 center_m{0, 0, 0};
  glm::dmat3 axes{1.0};  // of positive determinant
  ObjectLib::ObjectShape shape{};
};
// Requires: an object that check() passes.
Primitive primitive(const Object& object);

// A box in the world that the primitive lies in, to rounding.
struct ObjectBounds {
  glm::dvec3 low_m, high_m;
};
ObjectBounds bounds(const Primitive& primitive);

// The coefficients in the frame of the box, which is [-1, 1]^3 there; the greatest becomes 1.
std::array<double, 10> quadric_in_box(const Quadric& quadric);

// Along its principal axes, unit and perpendicular, with s_i = vectors[i] p, a quadric is the sum of values[i] s_i^2 +
// slopes[i] s_i, and the last coefficient. Greatest value first.
struct QuadricAxes {
  double values[3];
  glm::dvec3 vectors[3];
  double slopes[3];
};
QuadricAxes quadric_axes(const std::array<double, 10>& coefficients);

}  // namespace roadgen
