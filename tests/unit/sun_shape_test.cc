// What shadows are taken from against the shapes themselves: the last place where a ray meets them.
#include "roadgen/render/sun_shape.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "roadgen/object/rays.h"
#include "tests/object_shapes.h"

namespace roadgen {
namespace {

double last_of(const SunShape& s, glm::dvec3 origin, glm::dvec3 direction) {
  const glm::dmat3 inverse = glm::inverse(s.axes);
  return ObjectLib::quadric_last(inverse * (origin - s.center_m), inverse * direction, s.shape);
}

TEST(SunShape, TheLastHitIsTheShapesOwn) {
  test::ShapeRandom random(3);
  int met = 0, other = 0;
  for (int i = 0; i < 60000; ++i) {
    Object object;
    object.shape = test::random_shape(i % test::kShapeKinds, random);
    object.transform = glm::dmat4(random.rotation() * random.scale(0.1, 10));
    object.transform[3] = glm::dvec4(random.direction() * 5.0, 1);
    const Primitive p = primitive(object);
    const SunShape sun = sun_shape(p);
    if (sun.torus) continue;
    const glm::dvec3 middle(object.transform[3]), size(object.transform[0]);
    const glm::dvec3 from = middle + random.direction() * (3 * glm::length(size));
    const glm::dvec3 to = middle + random.direction() * (random.uniform(0, 1) * glm::length(size));
    const auto hits = all_hits(p, from, to - from);
    const double last = last_of(sun, from, to - from);
    met += !hits.empty();
    // Flat shapes, which are a little thick here, may differ where they are grazed.
    other += hits.empty() != (last <= -OBJECT_FAR) || (!hits.empty() && std::abs(last - hits.back().t) > 2e-3);
  }
  std::printf("%d rays meet, %d differ\n", met, other);
  EXPECT_GT(met, 20000);
  EXPECT_LT(other, 40);
}

// The same as the list's last, for quadrics of every type, open and solid, from everywhere.
TEST(SunShape, QuadricLastIsTheLastOfQuadricHits) {
  test::ShapeRandom random(4);
  for (int i = 0; i < 60000; ++i) {
    Object object;
    object.shape = test::random_shape(7, random);
    const Primitive p = primitive(object);
    if (p.kind != PrimitiveKind::kQuadric || (p.shape.flags & OBJECT_PLANES) != 0) continue;
    const glm::dvec3 o = random.direction() * random.uniform(0, 4), d = random.direction();
    const auto hits = ObjectLib::quadric_hits(o, d, ObjectLib::quadric_value(o, p.shape), p.shape);
    const double last = ObjectLib::quadric_last(o, d, p.shape);
    if (hits.count == 0) {
      EXPECT_LE(last, -OBJECT_FAR);
    } else {
      EXPECT_NEAR(last, hits.k[hits.count - 1], 1e-6);
    }
  }
}

}  // namespace
}  // namespace roadgen
