#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/export/mesh_builder.h"
#include "roadgen/export/triangulate.h"

namespace roadgen {
namespace {

constexpr double kStep_m = 2;         // along the boundary, at most
constexpr double kShortest_m = 0.02;  // edges are not halved further

using Ring = std::vector<glm::dvec2>;

// The boundary in steps of at most kStep_m and sagitta at most error_m, counter-clockwise from the area's centre.
Ring boundary(const Junction& junction, const JunctionSurface& surface, double error_m) {
  Ring ring;
  const auto add = [&](glm::dvec2 p) {
    p -= glm::dvec2(surface.center_m);
    if (ring.empty() || glm::distance(ring.back(), p) > 1e-6) ring.push_back(p);
  };
  for (std::size_t i = 0; i < junction.arms.size(); ++i) {
    const JunctionArm& arm = junction.arms[i];
    const auto along_cut = [&](double from, double to) {
      const int count = std::max(1, static_cast<int>(std::ceil((from - to) / kStep_m)));
      for (int k = 0; k <= count; ++k) add(cut_point_m(arm, from + (to - from) * k / count));
    };
    along_cut(arm.left_m, 0);
    along_cut(0, arm.right_m);
    for (const Segment& piece : junction.corners[i]) {
      const double bend = std::max({std::abs(curvature_per_m(piece, 0)), std::abs(curvature_per_m(piece, 0.5)),
                                    std::abs(curvature_per_m(piece, 1)), 1e-9});
      const double h = std::min(kStep_m, std::sqrt(8 * error_m / bend));
      const int count = static_cast<int>(std::ceil(piece.arc_m / h));
      for (int k = 1; k <= count; ++k) add(position_m(piece, u_at_arc(piece, piece.arc_m * k / count)));
    }
  }
  while (ring.size() > 1 && glm::distance(ring.front(), ring.back()) < 1e-6) ring.pop_back();
  return ring;
}

// Triangles over the plane that share vertices, and the surface's heights there.
class AreaMesh {
 public:
  AreaMesh(const std::vector<std::array<glm::dvec2, 3>>& triangles, const JunctionSurface& surface)
      : surface_(surface) {
    std::map<std::pair<double, double>, std::uint32_t> known;
    for (const auto& from : triangles) {
      Face face;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [at, is_new] = known.try_emplace({from[k].x, from[k].y}, static_cast<std::uint32_t>(points.size()));
        if (is_new) add(from[k]);
        face.corners[k] = at->second;
      }
      faces.push_back(face);
    }
  }

  // Halves the longest edges of faces that are off by more than wanted, with the faces beside them. Returns what the
  // worst face is off by, at its centre and the middles of its sides.
  double refine(double wanted_m) {
    for (;;) {
      double worst = 0;
      std::vector<std::pair<double, Edge>> bad;
      for (Face& face : faces) {
        if (face.error_m < 0) face.error_m = error_m(face);
        worst = std::max(worst, face.error_m);
        if (face.error_m <= wanted_m) continue;
        std::size_t longest = 0;
        for (std::size_t k = 1; k < 3; ++k) {
          if (length_m(edge(face, k)) > length_m(edge(face, longest))) longest = k;
        }
        const Edge e = edge(face, longest);
        if (length_m(e) > kShortest_m) bad.push_back({-length_m(e), e});
      }
      if (bad.empty() || faces.size() > kMostTriangles) return worst;
      std::map<Edge, std::vector<std::size_t>> faces_of;
      for (std::size_t f = 0; f < faces.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) faces_of[edge(faces[f], k)].push_back(f);
      }
      std::sort(bad.begin(), bad.end());
      std::vector<bool> touched(faces.size(), false);
      for (const auto& [length, e] : bad) {
        const auto& sides = faces_of[e];
        if (std::any_of(sides.begin(), sides.end(), [&](std::size_t f) { return touched[f]; })) continue;
        add(0.5 * (points[e.first] + points[e.second]));
        for (const std::size_t f : sides) {
          touched[f] = true;
          split(f, e);
        }
      }
    }
  }

  struct Face {
    std::array<std::uint32_t, 3> corners{};
    double error_m = -1;  // not yet known
  };
  Ring points;  // from the area's centre
  std::vector<double> heights_m;
  std::vector<Face> faces;

 private:
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  static Edge edge(const Face& face, std::size_t k) { return std::minmax(face.corners[k], face.corners[(k + 1) % 3]); }
  double length_m(const Edge& e) const { return glm::distance(points[e.first], points[e.second]); }
  double height_m(glm::dvec2 p) const { return height_at(surface_, glm::dvec2(surface_.center_m) + p).height_m; }
  void add(glm::dvec2 p) {
    points.push_back(p);
    heights_m.push_back(height_m(p));
  }
  double error_m(const Face& face) const {
    double worst = 0;
    for (const glm::dvec3& w :
         {glm::dvec3(1, 1, 1) / 3.0, glm::dvec3(0.5, 0.5, 0), glm::dvec3(0, 0.5, 0.5), glm::dvec3(0.5, 0, 0.5)}) {
      glm::dvec2 p(0, 0);
      double z = 0;
      for (int k = 0; k < 3; ++k) {
        p += w[k] * points[face.corners[static_cast<std::size_t>(k)]];
        z += w[k] * heights_m[face.corners[static_cast<std::size_t>(k)]];
      }
      worst = std::max(worst, std::abs(z - height_m(p)));
    }
    return worst;
  }
  // The newest point is the edge's middle.
  void split(std::size_t f, const Edge& e) {
    const auto middle = static_cast<std::uint32_t>(points.size() - 1);
    Face other;
    other.corners = faces[f].corners;
    for (std::size_t k = 0; k < 3; ++k) {
      if (edge(faces[f], k) != e) continue;
      other.corners[k] = middle;
      faces[f].corners[(k + 1) % 3] = middle;
      break;
    }
    faces[f].error_m = -1;
    faces.push_back(other);
  }

  const JunctionSurface& surface_;
};

}  // namespace

Status add_junction(const Junction& junction, double max_error_m, NetworkMesh& mesh) {
  const JunctionSurface surface = junction_surface(junction);
  AreaMesh area(triangulated(boundary(junction, surface, 0.5 * max_error_m)), surface);
  if (area.faces.empty()) {
    return Error{ErrorCode::kGeometry,
                 "its area cannot be cut into triangles; see roadgen check",
                 {},
                 0,
                 "junction " + junction.id};
  }
  // Half of it, since samples do not find the very worst.
  const double error_m = 2 * area.refine(0.25 * max_error_m);
  if (mesh.triangles + area.faces.size() > kMostTriangles) {
    return Error{ErrorCode::kData,
                 "the mesh would have more than 50 million triangles; allow a greater error",
                 {},
                 0,
                 "junction " + junction.id};
  }
  MeshBuilder builder("junction " + junction.id, surface.center_m);
  MeshPart& part = builder.part("asphalt", Lib::material_albedo(0, 0.3, 0.3, 0, 0, 1000, 1000));
  for (std::size_t i = 0; i < area.points.size(); ++i) {
    const JunctionPoint at = height_at(surface, glm::dvec2(surface.center_m) + area.points[i]);
    builder.vertex(part, {glm::dvec2(surface.center_m) + area.points[i], area.heights_m[i]},
                   glm::normalize(glm::dvec3(-at.gradient, 1)));
  }
  for (const AreaMesh::Face& face : area.faces) {
    builder.triangle(part, face.corners[0], face.corners[1], face.corners[2]);
  }
  mesh.error_m = std::max(mesh.error_m, error_m + 0.5 * max_error_m);
  mesh.triangles += builder.triangles();
  mesh.items.push_back(builder.take());
  return Done{};
}

}  // namespace roadgen
