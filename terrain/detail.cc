#include "terrain/detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "roadgen/road/parallel.h"
#include "terrain/bisection.h"
#include "terrain/terrain.h"

namespace roadgen {
namespace {

// Rounded up, so that sums of these keep what they bound.
float up(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

// The triangles that were halved, by how often: those of level i are order[first[i]] to order[first[i + 1]].
struct Halved {
  std::vector<std::int32_t> order;
  std::vector<std::size_t> first;
};

Halved halved(const Bisection& mesh) {
  Halved result;
  result.first.assign(static_cast<std::size_t>(mesh.finest()) + 1, 0);
  mesh.each_halved([&](std::int32_t i) { ++result.first[static_cast<std::size_t>(mesh.triangle(i).level) + 1]; });
  for (std::size_t i = 1; i < result.first.size(); ++i) result.first[i] += result.first[i - 1];
  result.order.resize(result.first.back());
  std::vector<std::size_t> next = result.first;
  mesh.each_halved([&](std::int32_t i) {
    result.order[next[static_cast<std::size_t>(mesh.triangle(i).level)]++] = i;
  });
  return result;
}

}  // namespace

VertexDetail vertex_detail(const Bisection& mesh, double unit_m, const std::function<bool(std::int32_t)>& is_sound) {
  constexpr float kNever = std::numeric_limits<float>::infinity();
  VertexDetail detail{std::vector<float>(mesh.vertices(), 0.0f), std::vector<float>(mesh.vertices(), 0.0f)};
  const Halved all = halved(mesh);
  const auto place = [&](std::uint32_t v) {
    return glm::dvec3(unit_m * glm::dvec2(mesh.lattice(v)), mesh.height(v));
  };
  const auto middle = [&](std::int32_t i) { return mesh.triangle(mesh.child(i)).apex; };
  // What joining all of a triangle moves the mesh by; of leaves 0.
  std::vector<float> moved(mesh.triangle_count(), 0.0f);
  std::vector<std::uint8_t> sound;
  for (std::size_t level = all.first.size() - 1; level-- > 0;) {
    const std::size_t begin = all.first[level], end = all.first[level + 1];
    sound.assign(end - begin, 0);
    for_each_index(end - begin, [&](std::size_t j) {
      const std::int32_t i = all.order[begin + j], child = mesh.child(i);
      bool may_be = true;
      for (const std::int32_t part : {child, child + 1}) {
        may_be = may_be && (mesh.child(part) < 0 || detail.error_m[middle(part)] < kNever);
      }
      sound[j] = may_be && is_sound(i);
    });
    for (std::size_t j = begin; j < end; ++j) {
      const std::int32_t i = all.order[j], child = mesh.child(i);
      const Bisection::Triangle& t = mesh.triangle(i);
      const std::uint32_t v = middle(i);
      const double step = std::abs(mesh.height(v) - 0.5 * (mesh.height(t.left) + mesh.height(t.right)));
      moved[static_cast<std::size_t>(i)] = up(step + std::max(moved[static_cast<std::size_t>(child)],
                                                              moved[static_cast<std::size_t>(child) + 1]));
      float& error = detail.error_m[v];
      error = std::max(error, sound[j - begin] ? moved[static_cast<std::size_t>(i)] : kNever);
      for (const std::int32_t part : {child, child + 1}) {
        if (mesh.child(part) < 0) continue;
        const std::uint32_t u = middle(part);
        error = std::max(error, detail.error_m[u]);
        detail.radius_m[v] =
            std::max(detail.radius_m[v], up(detail.radius_m[u] + 1.0001 * glm::length(place(u) - place(v))));
      }
    }
  }
  return detail;
}

void select_triangles(const TerrainMesh& tile, const Detail& detail, std::vector<std::uint32_t>& triangles) {
  triangles.clear();
  const glm::dvec3 eye = detail.eye_m - tile.origin_m;
  const auto is_kept = [&](std::uint32_t v) {
    const double away = glm::length(glm::dvec3(tile.positions_m[v]) - eye) - tile.radius_m[v] - detail.room_m;
    return tile.error_m[v] > detail.part * std::max(away, 0.0);
  };
  struct Pending {
    std::int32_t node;
    std::array<std::uint32_t, 3> corners;  // apex, left, right
  };
  std::vector<Pending> stack;
  for (std::int32_t root = 0; root < 2; ++root) stack.push_back({root, tile.roots[static_cast<std::size_t>(root)]});
  while (!stack.empty()) {
    const auto [at, c] = stack.back();
    stack.pop_back();
    const TerrainMesh::Node& node = tile.nodes[static_cast<std::size_t>(at)];
    if (node.child == TerrainMesh::Node::kCut) continue;
    if (node.child == TerrainMesh::Node::kLeaf || (detail.part > 0 && !is_kept(node.middle))) {
      triangles.insert(triangles.end(), c.begin(), c.end());
      continue;
    }
    stack.push_back({node.child + 1, {node.middle, c[2], c[0]}});
    stack.push_back({node.child, {node.middle, c[0], c[1]}});
  }
}

}  // namespace roadgen
