// Objects drawn exactly from a few numbers each, as data: shapes with a transform, materials, sets of many spheres.
//
//   ObjectScene scene;
//   scene.materials.push_back({.name = "brick", .base_color = {0.4f, 0.1f, 0.05f}});
//   scene.objects.push_back({.name = "tank", .shape = Cylinder{{0, 0, 0}, {0, 0, 4}, 2.5}});
//   for (const Diagnostic& fault : check(scene)) std::cerr << fault.text() << "\n";
//
// Positions are metres in double, of any frame that the object's transform maps to the world (ENU). Every shape is drawn
// as it is under any affine map: a sphere under a map that stretches is an ellipsoid, a cylinder an elliptic one.
// Source: S. M. Ranta, J. M. Singh, P. J. Narayanan, GPU Objects, 2006, section 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/result.h"

namespace roadgen {

// Flat shapes. Seen from both sides; the normal that is reported looks to the eye. -----------------------------------

struct Circle {
  glm::dvec3 center{0, 0, 0};
  glm::dvec3 normal{0, 0, 1};  // of any length but 0
  double radius = 1;           // > 0
};

// All center + x axis_u + y axis_v with x^2 + y^2 <= 1. The axes need not be perpendicular (conjugate half diameters).
struct Ellipse {
  glm::dvec3 center{0, 0, 0};
  glm::dvec3 axis_u{1, 0, 0}, axis_v{0, 1, 0};  // not parallel
};

// All origin + x axis_u + y axis_v with uu x^2 + vv y^2 + uv x y + u x + v y + one <= 0 and low <= (x, y) <= high:
// the inside of an ellipse, a parabola, a hyperbola, between lines.
struct Conic {
  glm::dvec3 origin{0, 0, 0};
  glm::dvec3 axis_u{1, 0, 0}, axis_v{0, 1, 0};            // not parallel
  std::array<double, 6> coefficients{1, 1, 0, 0, 0, -1};  // uu, vv, uv, u, v, one
  glm::dvec2 low{-1, -1}, high{1, 1};                     // low < high
};

struct Triangle {
  glm::dvec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};  // not on one line
};

// corner + x edge_u + y edge_v, x and y in [0, 1].
struct Parallelogram {
  glm::dvec3 corner{0, 0, 0}, edge_u{1, 0, 0}, edge_v{0, 1, 0};  // not parallel
};

// Solids. The normal looks outward. -----------------------------------------------------------------------------------

struct Sphere {
  glm::dvec3 center{0, 0, 0};
  double radius = 1;  // > 0
};

// center + M p, p in the unit ball, M the matrix of the three half axes, which need not be perpendicular.
struct Ellipsoid {
  glm::dvec3 center{0, 0, 0};
  glm::dvec3 axis_x{1, 0, 0}, axis_y{0, 1, 0}, axis_z{0, 0, 1};  // not in one plane
};

// Where xx x^2 + yy y^2 + zz z^2 + xy x y + xz x z + yz y z + x x + y y + z z + one = 0 within the box, any of the real
// types. solid: what is < 0 within the box, closed by the box's faces; else the surface alone, open, seen from both sides.
struct Quadric {
  std::array<double, 10> coefficients{1, 1, 1, 0, 0, 0, 0, 0, 0, -1};  // xx, yy, zz, xy, xz, yz, x, y, z, one
  glm::dvec3 box_low{-1, -1, -1}, box_high{1, 1, 1};                   // box_low < box_high
  bool solid = false;
};

// With flat ends.
struct Cylinder {
  glm::dvec3 from{0, 0, 0}, to{0, 0, 1};  // not the same
  double radius = 1;                      // > 0
};

// A cone or, with two radii > 0, its frustum, with flat ends. Radii >= 0, at least one > 0.
struct Cone {
  glm::dvec3 from{0, 0, 0}, to{0, 0, 1};
  double radius_from = 1, radius_to = 0;
};

// corner + x edge_x + y edge_y + z edge_z, each in [0, 1].
struct Parallelepiped {
  glm::dvec3 corner{0, 0, 0};
  glm::dvec3 edge_x{1, 0, 0}, edge_y{0, 1, 0}, edge_z{0, 0, 1};  // not in one plane
};

struct Tetrahedron {
  glm::dvec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{0, 0, 1};  // not in one plane
};

// All points at most minor_radius from a circle of major_radius around the axis.
struct Torus {
  glm::dvec3 center{0, 0, 0};
  glm::dvec3 axis{0, 0, 1};  // of any length but 0
  double major_radius = 1;   // > minor_radius
  double minor_radius = 0.25;
};

using Shape = std::variant<Circle, Ellipse, Conic, Triangle, Parallelogram, Sphere, Ellipsoid, Quadric, Cylinder, Cone,
                           Parallelepiped, Tetrahedron, Torus>;
// "sphere", "torus", ...
const char* shape_name(const Shape& shape);

// The regular tetrahedron with this apex, whose base lies from there along `direction` (of any length but 0), edges of
// length `side`. One edge of the base is horizontal where the direction is not.
Tetrahedron regular_tetrahedron(glm::dvec3 apex, glm::dvec3 direction, double side);

// From the symmetric matrix Q of p^T Q p = 0, p = (x, y, z, 1). Errors: kData: not symmetric to 1e-9 of its greatest
// element, or not finite.
Result<Quadric> quadric_from_matrix(const glm::dmat4& matrix, glm::dvec3 box_low, glm::dvec3 box_high);

// The kinds of quadrics over the reals.
enum class QuadricType {
  kEllipsoid,
  kImaginaryEllipsoid,  // no points
  kHyperboloidOneSheet,
  kHyperboloidTwoSheets,
  kCone,
  kPoint,  // a cone without further real points
  kEllipticParaboloid,
  kHyperbolicParaboloid,
  kEllipticCylinder,
  kImaginaryCylinder,  // no points
  kLine,               // two conjugate planes
  kHyperbolicCylinder,
  kIntersectingPlanes,
  kParabolicCylinder,
  kParallelPlanes,
  kImaginaryPlanes,  // no points
  kDoublePlane,
  kPlane,    // no quadratic part
  kNothing,  // all coefficients but the last are 0
};
// By the signs of the eigenvalues of its matrices, where those below 1e-12 of the greatest are taken for 0.
QuadricType quadric_type(const std::array<double, 10>& coefficients);
const char* quadric_type_name(QuadricType type);

// What light does on a surface. Colours are linear.
struct ObjectMaterial {
  enum class Model { kMetalRoughness, kPhong };
  std::string name = {};
  Model model = Model::kMetalRoughness;
  glm::vec3 base_color{0.5f, 0.5f, 0.5f};  // in [0, 1]
  float metallic = 0, roughness = 0.6f;    // kMetalRoughness, in [0, 1]; as in glTF 2.0
  glm::vec3 specular{0.2f, 0.2f, 0.2f};    // kPhong, in [0, 1]
  float shininess = 32;                    // kPhong, exponent, >= 1
  float reflection = 0;                    // part that is the mirrored environment alone, in [0, 1]
  float transmission = 0;                  // part of the light that goes through, in [0, 1]
  float ior = 1.5f;                        // index of refraction, in [1, 4]
  std::string texture_file = {};                // multiplies base_color by uv; empty: none
};

struct Object {
  std::string name;
  Shape shape;
  glm::dmat4 transform{1.0};   // world from the shape's frame, affine, not singular
  std::uint32_t material = 0;  // index in ObjectScene::materials
};

// Millions of spheres, 20 bytes each: molecules, point clouds. Centres are floats relative to the origin.
struct SphereSet {
  struct Item {
    glm::vec3 center;
    float radius;                                           // > 0
    std::array<std::uint8_t, 4> color{255, 255, 255, 255};  // sRGB and 255; times the material's base colour
  };
  std::string name;
  glm::dvec3 origin_m{0, 0, 0};  // in the world
  std::vector<Item> items;
  std::uint32_t material = 0;
};

struct ObjectScene {
  std::vector<Object> objects;
  std::vector<SphereSet> sphere_sets;
  std::vector<ObjectMaterial> materials;  // none: all objects take ObjectMaterial{}

  // Objects and the spheres of all sets. Instance i of the scene is object i, or the sphere of that place in all sets
  // one after the other after the objects.
  std::size_t instances() const;
};

// Every fault that a scene cannot be drawn with, at most `most`, each an error with the element "object 3 (NAME)" or
// "sphere set 0 (NAME)". None: the scene may be drawn. Cost: linear.
Diagnostics check(const ObjectScene& scene, std::size_t most = 100);

}  // namespace roadgen
