// Roads and junctions as triangles, for tools that need meshes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/network.h"

namespace roadgen {

struct MeshOptions {
  // Greatest allowed distance between the mesh and the road surface, either way, m. In [kLeastMeshError_m, 1].
  double max_error_m = 0.01;
};
inline constexpr double kLeastMeshError_m = 1e-4;
// Marks and paint are meshes of their own, this far above the lanes that they lie on, m.
inline constexpr double kMarkLift_m = 0.005;
// The greatest mesh that is made.
inline constexpr std::size_t kMostTriangles = 50'000'000;

// Triangles of one colour, counter-clockwise seen from above or from the open side. positions: metres from the item's
// origin, ENU; normals: unit.
struct MeshPart {
  std::string name;            // "asphalt" ... of the lanes, "white" ... of the paint, "tunnel" ... of structures
  glm::dvec3 albedo{0, 0, 0};  // linear
  std::vector<glm::vec3> positions, normals;
  std::vector<std::uint32_t> triangles;  // three a triangle
};

struct MeshItem {
  std::string name;  // "road ID", "junction ID" or "structure N of road ID"
  glm::dvec3 origin_m{0, 0, 0};
  std::vector<MeshPart> parts;  // no two of one name
};

struct NetworkMesh {
  std::vector<MeshItem> items;  // a road is several where it reaches more than a kilometre from an item's origin
  std::size_t triangles = 0;
  // Upper bound of the distance between mesh and surface: proven for roads, by sampling for junctions. The rounding of
  // positions to float adds at most 1e-4 m.
  double error_m = 0;
};

// All lanes with their faces, marks and paint, the areas of junctions, and the structures along roads: profiles as
// polygons whose corners lie on them, closed where the profile ends, and posts.
//
// Rows of vertices stand across the road, the same for all strips of a segment. Between rows h apart in s the strip
// between borders A and B is the image of (s, w), P = (1 - w) A(s) + w B(s), and two triangles interpolate it at the
// corners of a rectangle. For any x* in a triangle, sum l_i (s_i - s*)^2 <= h^2 / 4 and likewise for w, so by Taylor's
// theorem and Cauchy's inequality |triangle - P| <= max |P_ss| h^2 / 8 + max |P_sw| h / 4, taken for the plan and for
// the height: e_plan, e_z. The distance is at most hypot(e_plan, e_z); and, as a point of the triangle also has a point
// of the surface right above or below it but for the edges' own sagitta e_edge, at most e_z + slope e_plan + e_edge (1 +
// slope). The smaller counts. P_ss and P_sw are bounded by the maxima of curvature, its derivative, the profiles and the
// borders over the segment: with T' = k N, N' = -k T, A = C + n N gives A'' = k N + n'' N - 2 n' k T - n (k' T + k^2 N).
//
// Errors: kUsage for options out of range; kData where the mesh would have more than kMostTriangles.
// Cost: proportional to the triangles.
Result<NetworkMesh> tessellate(const Network& network, const MeshOptions& options = {});

// The convex polygons that a piece of paint is made of, about its centre: x along the road, y to the left,
// counter-clockwise.
std::vector<std::vector<glm::dvec2>> outlines(const Paint& paint);

}  // namespace roadgen
