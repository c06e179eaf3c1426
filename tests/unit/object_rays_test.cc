// Objects as data and as rays: faults by name, types of quadrics, closed forms, and what all shapes have in common.
#include "roadgen/object/rays.h"

#include <cmath>
#include <limits>
#include <thread>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tests/object_shapes.h"

namespace roadgen {
namespace {

using test::ShapeRandom;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Object object_of(Shape shape) { return {.name = "post", .shape = shape}; }

std::string fault_of(Object object) {
  ObjectScene scene;
  scene.objects.resize(3);
  scene.objects.push_back(object);
  const Diagnostics found = check(scene);
  return found.empty() ? "" : found[0].text();
}

TEST(ObjectCheck, NamesTheObjectAndWhatIsWrong) {
  const auto expect = [](Shape shape, const std::string& what) {
    const std::string text = fault_of(object_of(shape));
    EXPECT_NE(text.find("object 3 (post)"), std::string::npos) << text;
    EXPECT_NE(text.find(what), std::string::npos) << text;
  };
  expect(Sphere{{0, 0, 0}, 0}, "radius");
  expect(Sphere{{0, 0, 0}, -1}, "radius");
  expect(Sphere{{0, kNan, 0}, 1}, "not finite");
  expect(Circle{{0, 0, 0}, {0, 0, 0}, 1}, "normal");
  expect(Triangle{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, "degenerate");
  expect(Tetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, "degenerate");
  expect(Cone{{0, 0, 0}, {0, 0, 1}, -1, 1}, "negative");
  expect(Cone{{0, 0, 0}, {0, 0, 1}, 0, 0}, "radius");
  expect(Cylinder{{0, 0, 1}, {0, 0, 1}, 1}, "apart");
  expect(Torus{{0, 0, 0}, {0, 0, 1}, 1, 1.5}, "minor radius");
  expect(Quadric{{0, 0, 0, 0, 0, 0, 0, 0, 0, 1}}, "singular");
  expect(Quadric{{1, 1, 1, 0, 0, 0, 0, 0, 0, 1}}, "no real points");
  expect(Quadric{{1, 1, 1, 0, 0, 0, 0, 0, 0, 0}}, "singular");
  expect(Quadric{{1, 1, 1, 0, 0, 0, 0, 0, 0, -1}, {1, -1, -1}, {-1, 1, 1}}, "box");
  expect(Conic{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0, 0, 0, -1}}, "coefficients");
  EXPECT_EQ(fault_of(object_of(Sphere{})), "");
}

TEST(ObjectCheck, RefusesTransformsAndMaterials) {
  Object object = object_of(Sphere{});
  object.transform[1] = object.transform[0];
  EXPECT_NE(fault_of(object).find("singular"), std::string::npos);
  object.transform = glm::dmat4(kNan);
  EXPECT_NE(fault_of(object).find("not finite"), std::string::npos);
  object.transform = glm::dmat4(1);
  object.transform[0][3] = 0.5;
  EXPECT_NE(fault_of(object).find("affine"), std::string::npos);
  object = object_of(Sphere{});
  object.material = 4;
  EXPECT_NE(fault_of(object).find("material"), std::string::npos);
  ObjectScene scene;
  scene.sphere_sets.emplace_back().name = "atoms";
  scene.sphere_sets[0].items = {{{0, 0, 0}, 1}, {{0, 0, 0}, -1}};
  ASSERT_EQ(check(scene).size(), 1u);
  EXPECT_EQ(check(scene)[0].element, "sphere set 0 (atoms)");
  EXPECT_NE(check(scene)[0].message.find("sphere 1"), std::string::npos);
  EXPECT_TRUE(check(ObjectScene{}).empty());
}

TEST(Quadrics, AreOfEveryRealType) {
  using T = QuadricType;
  const struct {
    std::array<double, 10> q;
    T type;
  } cases[] = {
      {{1, 2, 3, 0, 0, 0, 0, 0, 0, -1}, T::kEllipsoid},
      {{1, 2, 3, 0, 0, 0, 0, 0, 0, 1}, T::kImaginaryEllipsoid},
      {{1, 1, -1, 0, 0, 0, 0, 0, 0, -1}, T::kHyperboloidOneSheet},
      {{1, 1, -1, 0, 0, 0, 0, 0, 0, 1}, T::kHyperboloidTwoSheets},
      {{1, 1, -1, 0, 0, 0, 0, 0, 0, 0}, T::kCone},
      {{1, 2, 1, 0, 0, 0, 0, 0, 0, 0}, T::kPoint},
      {{1, 2, 0, 0, 0, 0, 0, 0, -1, 0}, T::kEllipticParaboloid},
      {{1, -2, 0, 0, 0, 0, 0, 0, -1, 0}, T::kHyperbolicParaboloid},
      {{1, 2, 0, 0, 0, 0, 0, 0, 0, -1}, T::kEllipticCylinder},
      {{1, 2, 0, 0, 0, 0, 0, 0, 0, 1}, T::kImaginaryCylinder},
      {{1, 2, 0, 0, 0, 0, 0, 0, 0, 0}, T::kLine},
      {{1, -2, 0, 0, 0, 0, 0, 0, 0, -1}, T::kHyperbolicCylinder},
      {{1, -2, 0, 0, 0, 0, 0, 0, 0, 0}, T::kIntersectingPlanes},
      {{1, 0, 0, 0, 0, 0, 0, 1, 0, 0}, T::kParabolicCylinder},
      {{1, 0, 0, 0, 0, 0, 0, 0, 0, -1}, T::kParallelPlanes},
      {{1, 0, 0, 0, 0, 0, 0, 0, 0, 1}, T::kImaginaryPlanes},
      {{1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, T::kDoublePlane},
      {{0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, T::kPlane},
      {{0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, T::kNothing},
  };
  ShapeRandom random(3);
  for (const auto& c : cases) {
    EXPECT_EQ(quadric_type(c.q), c.type) << quadric_type_name(c.type);
    // Turned, moved, and with the other sign.
    const glm::dmat3 r = random.rotation();
    const glm::dvec3 m = random.direction();
    glm::dmat4 q(0), map(1);
    const auto& a = c.q;
    q = {{a[0], a[3] / 2, a[4] / 2, a[6] / 2},
         {a[3] / 2, a[1], a[5] / 2, a[7] / 2},
         {a[4] / 2, a[5] / 2, a[2], a[8] / 2},
         {a[6] / 2, a[7] / 2, a[8] / 2, a[9]}};
    for (int i = 0; i < 3; ++i) map[i] = glm::dvec4(r[i], 0);
    map[3] = glm::dvec4(m, 1);
    const auto moved = quadric_from_matrix(-(glm::transpose(map) * q * map), {-1, -1, -1}, {1, 1, 1});
    ASSERT_TRUE(moved.ok());
    EXPECT_EQ(quadric_type(moved->coefficients), c.type) << quadric_type_name(c.type);
  }
  glm::dmat4 skew(1);
  skew[0][1] = 1;
  EXPECT_FALSE(quadric_from_matrix(skew, {-1, -1, -1}, {1, 1, 1}).ok());
}

TEST(ObjectHits, OfTheSphereAreTheClosedForm) {
  const Primitive p = primitive(object_of(Sphere{{1e5, 2, 3}, 2}));
  const auto hits = all_hits(p, {0, 2, 4}, {1, 0, 0});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_NEAR(hits[0].t, 1e5 - std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(hits[1].t, 1e5 + std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(hits[0].normal.z, 0.5, 1e-9);
  EXPECT_TRUE(all_hits(p, {0, 2, 5.001}, {1, 0, 0}).empty());
}

TEST(ObjectHits, OfTheTorusAreFourAlongItsMiddle) {
  const Primitive p = primitive(object_of(Torus{{0, 0, 0}, {0, 0, 1}, 2, 0.5}));
  const auto hits = all_hits(p, {-10, 0, 0}, {1, 0, 0});
  ASSERT_EQ(hits.size(), 4u);
  const double expected[] = {7.5, 8.5, 11.5, 12.5};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(hits[i].t, expected[i], 1e-12);
}

// Every hit lies on the surface, in order; a solid is entered and left by turns; the normal is the surface's own slope.
TEST(ObjectHits, HaveWhatAllShapesHave) {
  ShapeRandom random(11);
  for (int kind = 0; kind < test::kShapeKinds; ++kind) {
    int met = 0;
    for (int i = 0; i < 4000; ++i) {
      Object object = object_of(test::random_shape(kind, random));
      const double size = random.scale(1e-3, 1e4);
      object.transform = glm::dmat4(random.rotation() * size);
      object.transform[3] = glm::dvec4(random.direction() * size * random.uniform(0, 50), 1);
      const Primitive p = primitive(object);
      const PrimitiveRow& row = primitive_row(p.kind);
      EXPECT_GT(glm::determinant(p.axes), 0);
      const glm::dvec3 target = p.center_m + p.axes * (random.direction() * random.uniform(0, 1));
      const glm::dvec3 origin = target + random.direction() * size * random.scale(1e-2, 1e5);
      const auto hits = all_hits(p, origin, target - origin);
      met += !hits.empty();
      const bool solid = (p.shape.flags & OBJECT_SOLID) != 0;
      EXPECT_TRUE(!solid || hits.size() % 2 == 0) << shape_name(object.shape);
      const ObjectBounds box = bounds(p);
      for (std::size_t k = 0; k < hits.size(); ++k) {
        const glm::dvec3 local = glm::inverse(p.axes) * (hits[k].position_m - p.center_m);
        // From 1e5 sizes away a double keeps 1e-11 of them, times the shape's own slope.
        if (row.kind != PrimitiveKind::kQuadric && row.kind != PrimitiveKind::kCone) {
          EXPECT_NEAR(row.value(local, p.shape), 0, 1e-7) << shape_name(object.shape);
        } else if (hits[k].face == 0) {
          EXPECT_NEAR(row.value(local, p.shape), 0, 1e-7) << shape_name(object.shape);
        }
        EXPECT_TRUE(k == 0 || hits[k - 1].t <= hits[k].t);
        const double facing = glm::dot(hits[k].normal, glm::normalize(target - origin));
        const double outward = solid && k % 2 == 1 ? -facing : facing;
        EXPECT_LE(outward, 1e-5) << shape_name(object.shape) << " hit " << k;
        EXPECT_NEAR(glm::length(hits[k].normal), 1, 1e-12);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_GE(hits[k].position_m[axis], box.low_m[axis] - 1e-8 * size) << shape_name(object.shape);
          EXPECT_LE(hits[k].position_m[axis], box.high_m[axis] + 1e-8 * size) << shape_name(object.shape);
        }
        EXPECT_GE(hits[k].uv.x, -1e-7);
        EXPECT_LE(hits[k].uv.x, 1 + 1e-7);
      }
    }
    EXPECT_GT(met, 400) << kind;
  }
}

// Against steps along the ray that are far smaller than the tube: no hole, nothing twice.
TEST(ObjectHits, OfTheTorusMissNoRoot) {
  ShapeRandom random(5);
  using Lib = ObjectLib;
  for (int i = 0; i < 3000; ++i) {
    Lib::ObjectShape s{};
    s.p0 = random.scale(0.02, 0.98);
    const glm::dvec3 on = random.direction() * random.uniform(0, 1.2), d = random.direction();
    const glm::dvec3 o = on - d * glm::dot(on, d);
    const Lib::ObjectHits h = Lib::torus_hits(o, d, 0, s);
    int changes = 0;
    double least = 1;
    bool inside = false;
    const double reach = 2.1, step = 2e-4;
    for (double k = -reach; k <= reach; k += step) {
      const double value = Lib::torus_value(o + d * k, s);
      least = std::min(least, std::abs(value));
      if ((value < 0) != inside) ++changes, inside = value < 0;
    }
    // Two roots within one step are seen by neither count, or by one: there D is below step^2 at its extreme.
    if (h.count != changes) {
      bool close = false;
      for (int k = 1; k < h.count; ++k) close |= h.k[k] - h.k[k - 1] < 2 * step;
      EXPECT_TRUE(close) << h.count << " roots, " << changes << " changes of sign";
    }
  }
}

TEST(ObjectRays, NearestIsTheNearestOfAll) {
  ShapeRandom random(21);
  ObjectScene scene;
  for (int i = 0; i < 400; ++i) {
    Object object = object_of(test::random_shape(i % test::kShapeKinds, random));
    object.transform = glm::dmat4(random.rotation() * random.scale(0.05, 2));
    object.transform[3] = glm::dvec4(glm::dvec3(4e5, -3e5, 100) + random.direction() * random.uniform(0, 12), 1);
    scene.objects.push_back(object);
  }
  scene.sphere_sets.emplace_back().origin_m = {4e5, -3e5, 100};
  for (int i = 0; i < 300; ++i) {
    scene.sphere_sets[0].items.push_back(
        {glm::vec3(random.direction() * random.uniform(0, 12)), static_cast<float>(random.scale(0.05, 0.5))});
  }
  ASSERT_TRUE(check(scene).empty());
  const ObjectRays rays(scene);
  struct Ray {
    glm::dvec3 origin, direction;
  };
  std::vector<Ray> cast;
  for (int i = 0; i < 3000; ++i) {
    const glm::dvec3 to = glm::dvec3(4e5, -3e5, 100) + random.direction() * random.uniform(0, 12);
    const glm::dvec3 from = to + random.direction() * random.scale(0.1, 1e5);
    cast.push_back({from, (to - from) * random.scale(1e-3, 1e3)});
  }
  // From four threads at once.
  std::vector<std::optional<ObjectHit>> found(cast.size());
  std::vector<std::thread> threads;
  for (std::size_t first = 0; first < 4; ++first) {
    threads.emplace_back([&, first] {
      for (std::size_t i = first; i < cast.size(); i += 4) found[i] = rays.nearest(cast[i].origin, cast[i].direction);
    });
  }
  for (std::thread& thread : threads) thread.join();
  int met = 0;
  for (std::size_t i = 0; i < cast.size(); ++i) {
    std::optional<ObjectHit> best;
    for (std::uint32_t k = 0; k < scene.instances(); ++k) {
      for (const ObjectHit& hit : all_hits(rays.primitive_of(k), cast[i].origin, cast[i].direction)) {
        if (hit.t < 0 || (best && best->t <= hit.t)) continue;
        best = hit;
        best->instance = k;
      }
    }
    ASSERT_EQ(found[i].has_value(), best.has_value());
    if (!best) continue;
    ++met;
    EXPECT_EQ(found[i]->t, best->t);
    EXPECT_EQ(found[i]->instance, best->instance);
  }
  EXPECT_GT(met, 1000);
  EXPECT_FALSE(ObjectRays(ObjectScene{}).nearest({0, 0, 0}, {1, 0, 0}));
}

}  // namespace
}  // namespace roadgen
