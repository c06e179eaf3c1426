#include "roadgen/render/sun_shape.h"

#include <array>

namespace roadgen {
namespace {

using Coefficients = std::array<double, 10>;  // as shaders/lib/quadric.glsl has them

// < 0 everywhere: the box alone.
constexpr Coefficients kAllInside = {-1e-3, -1e-3, -1e-3, 0, 0, 0, 0, 0, 0, -1};

// > 0 everywhere.
constexpr Coefficients kNothing = {1e-3, 1e-3, 1e-3, 0, 0, 0, 0, 0, 0, 1};

// (n p + e)(m p + f); where both are one plane n p + e, of which a solid has nothing inside.
Coefficients product(const ObjectLib::ObjectShape& s) {
  const glm::dvec3 n(s.p0, s.p1, s.p2), m(s.p4, s.p5, s.p6);
  const double e = s.p3, f = s.p7;
  if (n == m && e == f && (s.flags & OBJECT_SOLID) != 0) return kNothing;
  if (n == m && e == f) return {0, 0, 0, 0, 0, 0, n.x, n.y, n.z, e};
  return {n.x * m.x,
          n.y * m.y,
          n.z * m.z,
          n.x * m.y + n.y * m.x,
          n.x * m.z + n.z * m.x,
          n.y * m.z + n.z * m.y,
          n.x * f + m.x * e,
          n.y * f + m.y * e,
          n.z * f + m.z * e,
          e * f};
}

Coefficients coefficients(PrimitiveKind kind, const ObjectLib::ObjectShape& s) {
  switch (kind) {
    case PrimitiveKind::kSphere: return {1, 1, 1, 0, 0, 0, 0, 0, 0, -1};
    case PrimitiveKind::kCone: return {1, 1, -s.p1 * s.p1, 0, 0, 0, 0, 0, -2 * s.p0 * s.p1, -s.p0 * s.p0};
    case PrimitiveKind::kDisc: return {1, 1, 0, 0, 0, 0, 0, 0, 0, -1};
    case PrimitiveKind::kConic: return {s.p0, s.p1, 0, s.p2, 0, 0, s.p3, s.p4, 0, s.p5};
    // In a box at the corner, half as large: x + y <= 1/3 and x + y + z <= 1/4.
    case PrimitiveKind::kTriangle: return {0, 0, 0, 0, 0, 0, 0.5, 0.5, 0, 0};
    case PrimitiveKind::kTetra: return {0, 0, 0, 0, 0, 0, 0.5, 0.5, 0.5, 0.5};
    case PrimitiveKind::kQuadric:
      if ((s.flags & OBJECT_PLANES) != 0) return product(s);
      return {s.p0, s.p1, s.p2, s.p3, s.p4, s.p5, s.p6, s.p7, s.p8, s.p9};
    case PrimitiveKind::kBox:
    case PrimitiveKind::kRhomb:
    case PrimitiveKind::kTorus: break;  // a torus is its own
  }
  return kAllInside;
}

}  // namespace

SunShape sun_shape(const Primitive& p) {
  SunShape out{p.kind == PrimitiveKind::kTorus, p.center_m, p.axes, p.shape};
  if (out.torus) return out;
  const Coefficients q = coefficients(p.kind, p.shape);
  const bool open = p.kind == PrimitiveKind::kQuadric && (p.shape.flags & OBJECT_SOLID) == 0;
  out.shape = {q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7], q[8], q[9], open ? 0 : OBJECT_SOLID};
  if (p.kind == PrimitiveKind::kTriangle) {
    out.center_m += (p.axes[0] + p.axes[1]) / 6.0;
    out.axes[0] *= 0.5;
    out.axes[1] *= 0.5;
  }
  if (p.kind == PrimitiveKind::kTetra) {
    out.center_m += (p.axes[0] + p.axes[1] + p.axes[2]) * 0.25;
    out.axes *= 0.5;
  }
  if (primitive_row(p.kind).flat) out.axes[2] *= kSunThickness;
  return out;
}

}  // namespace roadgen
