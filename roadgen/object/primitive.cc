#include "roadgen/object/primitive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace roadgen {
namespace {

// By value, as the library declares them.
using Numbers = ObjectLib::ObjectShape;

#define PRIMITIVE(kind, name, proxy, flat, at_eye)                                                     \
  PrimitiveRow {                                                                                       \
    PrimitiveKind::kind, #name, Proxy::proxy, flat, at_eye,                                            \
        [](glm::dvec3 p, const Numbers& s) { return ObjectLib::name##_value(p, s); },                  \
        [](glm::dvec3 o, glm::dvec3 d, double at_o, const Numbers& s) {                                \
          return ObjectLib::name##_hits(o, d, at_o, s);                                                \
        },                                                                                             \
        [](glm::dvec3 p, int face, const Numbers& s) { return ObjectLib::name##_normal(p, face, s); }, \
        [](glm::dvec3 p, int face, const Numbers& s) { return ObjectLib::name##_uv(p, face, s); }      \
  }

// One row a primitive.
const PrimitiveRow kTable[] = {
    PRIMITIVE(kSphere, sphere, kOutline, false, true),
    PRIMITIVE(kQuadric, quadric, kHull, false, true),
    PRIMITIVE(kCone, cone, kOutline, false, true),
    PRIMITIVE(kBox, box, kBox, false, false),
    PRIMITIVE(kTetra, tetra, kTetra, false, false),
    PRIMITIVE(kTorus, torus, kRing, false, false),
    PRIMITIVE(kDisc, disc, kPolygon, true, false),
    PRIMITIVE(kConic, conic, kSquare, true, false),
    PRIMITIVE(kTriangle, triangle, kTriangle, true, false),
    PRIMITIVE(kRhomb, rhomb, kSquare, true, false),
};
#undef PRIMITIVE

// Two unit vectors across a unit vector, right-handed with it as the third.
void frame_around(glm::dvec3 z, glm::dvec3& x, glm::dvec3& y) {
  const glm::dvec3 other = std::abs(z.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  x = glm::normalize(glm::cross(other, z));
  y = glm::cross(z, x);
}

Primitive made(PrimitiveKind kind, glm::dvec3 center, glm::dvec3 x, glm::dvec3 y, glm::dvec3 z) {
  Primitive p{kind, center, glm::dmat3(x, y, z), {}};
  p.shape.flags = primitive_row(kind).flat ? 0 : OBJECT_SOLID;
  return p;
}

Primitive around(PrimitiveKind kind, glm::dvec3 center, glm::dvec3 axis, double out, double along) {
  glm::dvec3 x, y;
  const glm::dvec3 z = glm::normalize(axis);
  frame_around(z, x, y);
  return made(kind, center, x * out, y * out, z * along);
}

// A flat one: the third axis as long as the others, so that the frame is well conditioned.
Primitive flat(PrimitiveKind kind, glm::dvec3 center, glm::dvec3 x, glm::dvec3 y) {
  const glm::dvec3 normal = glm::cross(x, y);
  return made(kind, center, x, y, normal * (1 / std::sqrt(glm::length(normal))));
}

void set_numbers(Numbers& s, const double* values, int count) {
  double* const to[] = {&s.p0, &s.p1, &s.p2, &s.p3, &s.p4, &s.p5, &s.p6, &s.p7, &s.p8, &s.p9};
  for (int i = 0; i < count; ++i) *to[i] = values[i];
}

Primitive of(const Circle& s) { return around(PrimitiveKind::kDisc, s.center, s.normal, s.radius, s.radius); }
Primitive of(const Ellipse& s) { return flat(PrimitiveKind::kDisc, s.center, s.axis_u, s.axis_v); }

Primitive of(const Conic& s) {
  // In the bounds' frame: x = m + h X.
  const glm::dvec2 m = 0.5 * (s.low + s.high), h = 0.5 * (s.high - s.low);
  const auto& c = s.coefficients;
  double q[6] = {c[0] * h.x * h.x,
                 c[1] * h.y * h.y,
                 c[2] * h.x * h.y,
                 (2 * c[0] * m.x + c[2] * m.y + c[3]) * h.x,
                 (2 * c[1] * m.y + c[2] * m.x + c[4]) * h.y,
                 c[0] * m.x * m.x + c[1] * m.y * m.y + c[2] * m.x * m.y + c[3] * m.x + c[4] * m.y + c[5]};
  double greatest = 0;
  for (const double x : q) greatest = std::max(greatest, std::abs(x));
  for (double& x : q) x /= greatest;
  Primitive p = flat(PrimitiveKind::kConic, s.origin + s.axis_u * m.x + s.axis_v * m.y, s.axis_u * h.x, s.axis_v * h.y);
  set_numbers(p.shape, q, 6);
  return p;
}

Primitive of(const Triangle& s) {
  return flat(PrimitiveKind::kTriangle, (s.a + s.b + s.c) / 3.0, s.b - s.a, s.c - s.a);
}

Primitive of(const Parallelogram& s) {
  return flat(PrimitiveKind::kRhomb, s.corner + 0.5 * (s.edge_u + s.edge_v), 0.5 * s.edge_u, 0.5 * s.edge_v);
}

Primitive of(const Sphere& s) {
  return made(PrimitiveKind::kSphere, s.center, {s.radius, 0, 0}, {0, s.radius, 0}, {0, 0, s.radius});
}

Primitive of(const Ellipsoid& s) { return made(PrimitiveKind::kSphere, s.center, s.axis_x, s.axis_y, s.axis_z); }

// The two planes n p + e of a quadric that is their product, as p0 to p3 and p4 to p7. Of a double plane both are the same.
std::array<double, 10> planes_of(const std::array<double, 10>& q, QuadricType type) {
  const QuadricAxes a = quadric_axes(q);
  glm::dvec4 one, two;
  if (type == QuadricType::kIntersectingPlanes) {
    // v0 (s0 - c0)^2 + v1 (s1 - c1)^2 with values of unlike signs.
    const double r0 = std::sqrt(std::abs(a.values[0])), r1 = std::sqrt(std::abs(a.values[1]));
    const double c0 = -0.5 * a.slopes[0] / a.values[0], c1 = -0.5 * a.slopes[1] / a.values[1];
    one = {a.vectors[0] * r0 + a.vectors[1] * r1, -c0 * r0 - c1 * r1};
    two = {a.vectors[0] * r0 - a.vectors[1] * r1, -c0 * r0 + c1 * r1};
  } else {
    // v0 (s0 - c0)^2 = e
    const double c0 = -0.5 * a.slopes[0] / a.values[0];
    const double apart = type == QuadricType::kDoublePlane ? 0 : std::sqrt(std::max(0.0, c0 * c0 - q[9] / a.values[0]));
    const double r0 = std::sqrt(std::abs(a.values[0]));
    one = {a.vectors[0] * r0, (-c0 - apart) * r0};
    two = {a.vectors[0] * r0, (-c0 + apart) * r0};
  }
  if (a.values[0] < 0) one = -one;
  return {one.x, one.y, one.z, one.w, two.x, two.y, two.z, two.w, 0, 0};
}

// A whole ellipsoid within the box; else nothing.
std::optional<Primitive> ellipsoid_of(const std::array<double, 10>& q, const Primitive& box) {
  const QuadricAxes a = quadric_axes(q);
  double rest = q[9];
  for (int i = 0; i < 3; ++i) rest -= 0.25 * a.slopes[i] * a.slopes[i] / a.values[i];
  glm::dvec3 center(0), axes[3];
  for (int i = 0; i < 3; ++i) {
    center += a.vectors[i] * (-0.5 * a.slopes[i] / a.values[i]);
    axes[i] = a.vectors[i] * std::sqrt(-rest / a.values[i]);
  }
  for (int i = 0; i < 3; ++i) {
    const double reach = std::sqrt(axes[0][i] * axes[0][i] + axes[1][i] * axes[1][i] + axes[2][i] * axes[2][i]);
    if (!(std::abs(center[i]) + reach <= 1)) return std::nullopt;
  }
  return made(PrimitiveKind::kSphere, box.center_m + box.axes * center, box.axes * axes[0], box.axes * axes[1],
              box.axes * axes[2]);
}

Primitive of(const Quadric& s) {
  const glm::dvec3 m = 0.5 * (s.box_low + s.box_high), h = 0.5 * (s.box_high - s.box_low);
  Primitive p = made(PrimitiveKind::kQuadric, m, {h.x, 0, 0}, {0, h.y, 0}, {0, 0, h.z});
  std::array<double, 10> q = quadric_in_box(s);
  const QuadricType type = quadric_type(q);
  if (type == QuadricType::kEllipsoid) {
    if (const auto whole = ellipsoid_of(q, p)) return *whole;
  }
  if (!s.solid) p.shape.flags = 0;
  if (type == QuadricType::kIntersectingPlanes || type == QuadricType::kParallelPlanes ||
      type == QuadricType::kDoublePlane) {
    p.shape.flags |= OBJECT_PLANES;
    q = planes_of(q, type);
  }
  set_numbers(p.shape, q.data(), 10);
  return p;
}

Primitive of(const Cylinder& s) {
  Primitive p =
      around(PrimitiveKind::kCone, 0.5 * (s.from + s.to), s.to - s.from, s.radius, 0.5 * glm::length(s.to - s.from));
  p.shape.p0 = 1;
  return p;
}

Primitive of(const Cone& s) {
  const double greatest = std::max(s.radius_from, s.radius_to);
  Primitive p =
      around(PrimitiveKind::kCone, 0.5 * (s.from + s.to), s.to - s.from, greatest, 0.5 * glm::length(s.to - s.from));
  p.shape.p0 = 0.5 * (s.radius_from + s.radius_to) / greatest;
  p.shape.p1 = 0.5 * (s.radius_to - s.radius_from) / greatest;
  return p;
}

Primitive of(const Parallelepiped& s) {
  return made(PrimitiveKind::kBox, s.corner + 0.5 * (s.edge_x + s.edge_y + s.edge_z), 0.5 * s.edge_x, 0.5 * s.edge_y,
              0.5 * s.edge_z);
}

Primitive of(const Tetrahedron& s) {
  return made(PrimitiveKind::kTetra, 0.25 * (s.a + s.b + s.c + s.d), s.b - s.a, s.c - s.a, s.d - s.a);
}

Primitive of(const Torus& s) {
  Primitive p = around(PrimitiveKind::kTorus, s.center, s.axis, s.major_radius, s.major_radius);
  p.shape.p0 = s.minor_radius / s.major_radius;
  return p;
}

// The same shape in a frame that is mirrored across x.
void mirror(Primitive& p) {
  p.axes[0] = -p.axes[0];
  Numbers& s = p.shape;
  if (p.kind == PrimitiveKind::kQuadric && (s.flags & OBJECT_PLANES) != 0) {
    s.p0 = -s.p0, s.p4 = -s.p4;
  } else if (p.kind == PrimitiveKind::kQuadric) {
    s.p3 = -s.p3, s.p4 = -s.p4, s.p6 = -s.p6;
  }
  if (p.kind == PrimitiveKind::kConic) s.p2 = -s.p2, s.p3 = -s.p3;
}

}  // namespace

std::span<const PrimitiveRow> primitive_table() { return kTable; }

std::array<double, 10> quadric_in_box(const Quadric& s) {
  const glm::dvec3 m = 0.5 * (s.box_low + s.box_high), h = 0.5 * (s.box_high - s.box_low);
  const auto& c = s.coefficients;
  std::array<double, 10> q = {c[0] * h.x * h.x,
                              c[1] * h.y * h.y,
                              c[2] * h.z * h.z,
                              c[3] * h.x * h.y,
                              c[4] * h.x * h.z,
                              c[5] * h.y * h.z,
                              (2 * c[0] * m.x + c[3] * m.y + c[4] * m.z + c[6]) * h.x,
                              (c[3] * m.x + 2 * c[1] * m.y + c[5] * m.z + c[7]) * h.y,
                              (c[4] * m.x + c[5] * m.y + 2 * c[2] * m.z + c[8]) * h.z,
                              m.x * (c[0] * m.x + c[3] * m.y + c[4] * m.z + c[6]) +
                                  m.y * (c[1] * m.y + c[5] * m.z + c[7]) + m.z * (c[2] * m.z + c[8]) + c[9]};
  double greatest = 0;
  for (const double x : q) greatest = std::max(greatest, std::abs(x));
  if (greatest > 0) {
    for (double& x : q) x /= greatest;
  }
  return q;
}

Primitive primitive(const Object& object) {
  Primitive p = std::visit([](const auto& shape) { return of(shape); }, object.shape);
  const glm::dmat3 linear(object.transform);
  p.center_m = linear * p.center_m + glm::dvec3(object.transform[3]);
  p.axes = linear * p.axes;
  const bool in_plane = primitive_row(p.kind).flat;
  if (in_plane) {
    // Its third axis is of our making: across the plane after the transform, too.
    const glm::dvec3 normal = glm::cross(p.axes[0], p.axes[1]);
    p.axes[2] = normal * (1 / std::sqrt(glm::length(normal)));
  }
  if (glm::determinant(p.axes) < 0) {
    if (p.kind == PrimitiveKind::kTetra) {
      std::swap(p.axes[0], p.axes[1]);
    } else {
      mirror(p);
    }
  }
  return p;
}

ObjectBounds bounds(const Primitive& p) {
  glm::dvec3 half(0);
  const glm::dmat3& a = p.axes;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(a[0][i], a[1][i], a[2][i]);
    const double xy = std::hypot(row.x, row.y), sum = std::abs(row.x) + std::abs(row.y);
    switch (p.kind) {
      case PrimitiveKind::kSphere: half[i] = glm::length(row); break;
      case PrimitiveKind::kCone: half[i] = xy + std::abs(row.z); break;
      case PrimitiveKind::kTorus: half[i] = xy + p.shape.p0 * glm::length(row); break;
      case PrimitiveKind::kDisc: half[i] = xy; break;
      case PrimitiveKind::kConic:
      case PrimitiveKind::kRhomb: half[i] = sum; break;
      case PrimitiveKind::kTetra:
      case PrimitiveKind::kTriangle: break;
      default: half[i] = sum + std::abs(row.z); break;  // [-1, 1]^3
    }
  }
  glm::dvec3 low = p.center_m - half, high = p.center_m + half;
  const bool tetra = p.kind == PrimitiveKind::kTetra;
  if (tetra || p.kind == PrimitiveKind::kTriangle) {
    const double part = tetra ? -0.25 : -1.0 / 3;
    const glm::dvec3 corner = p.center_m + part * (a[0] + a[1] + (tetra ? a[2] : glm::dvec3(0)));
    low = high = corner;
    for (int i = 0; i < (tetra ? 3 : 2); ++i) low = glm::min(low, corner + a[i]), high = glm::max(high, corner + a[i]);
  }
  return {low, high};
}

}  // namespace roadgen
