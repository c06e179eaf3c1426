#include "terrain/detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/parallel.h"
#include "terrain/bisection.h"
#include "terrain/ground_source.h"
#include "terrain/horizon.h"
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
  mesh.each_halved([&](std::int32_t i) { result.order[next[static_cast<std::size_t>(mesh.triangle(i).level)]++] = i; });
  return result;
}

}  // namespace

VertexDetail vertex_detail(const Bisection& mesh, double unit_m, const std::function<bool(std::int32_t)>& is_sound) {
  constexpr float kNever = std::numeric_limits<float>::infinity();
  VertexDetail detail{std::vector<float>(mesh.vertices(), 0.0f), std::vector<float>(mesh.vertices(), 0.0f)};
  const Halved all = halved(mesh);
  const auto place = [&](std::uint32_t v) { return glm::dvec3(unit_m * glm::dvec2(mesh.lattice(v)), mesh.height(v)); };
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
      moved[static_cast<std::size_t>(i)] =
          up(step + std::max(moved[static_cast<std::size_t>(child)], moved[static_cast<std::size_t>(child) + 1]));
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

namespace {

// The order of a tile's vertices: corners, which hang from none, then by error, of equal ones those first that others hang
// from.
std::vector<std::uint32_t> by_error(const TerrainMesh& tile) {
  std::vector<float> error = tile.error_m;
  for (const auto& root : tile.roots) {
    for (const std::uint32_t v : root) error[v] = std::numeric_limits<float>::infinity();
  }
  std::vector<std::uint32_t> order(error.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return error[a] > error[b]; });
  return order;
}

template <class T>
void permute(std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  std::vector<T> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result[i] = values[order[i]];
  values.swap(result);
}

}  // namespace

void order_by_error(TerrainMesh& tile) {
  constexpr std::uint32_t kLeastBand = 256;
  constexpr std::uint32_t kNone = ~0u;
  const std::vector<std::uint32_t> order = by_error(tile);
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  // The one or two triangles that each vertex halves.
  std::vector<std::array<std::uint32_t, 2>> halved(order.size(), {kNone, kNone});
  for (std::uint32_t i = 0; i < tile.nodes.size(); ++i) {
    if (tile.nodes[i].child < 0) continue;
    auto& of_middle = halved[tile.nodes[i].middle];
    of_middle[of_middle[0] == kNone ? 0 : 1] = i;
  }
  std::vector<std::uint32_t> node_order{0, 1}, node_place(tile.nodes.size(), 0);
  node_place[1] = 1;
  tile.bands.clear();
  float greatest_error = std::numeric_limits<float>::infinity(), greatest_radius = 0;
  std::uint32_t band_end = 0;  // where the next one ends at the earliest; 0: still in the first
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    const std::uint32_t v = order[i];
    const bool is_corner = halved[v][0] == kNone;
    const float error = is_corner ? std::numeric_limits<float>::infinity() : tile.error_m[v];
    if (!std::isinf(error) && i >= band_end) {
      if (i > 0)
        tile.bands.push_back({i, static_cast<std::uint32_t>(node_order.size()), greatest_error, greatest_radius});
      band_end = i + std::max(i, kLeastBand);
      greatest_error = error;
      greatest_radius = 0;
    }
    greatest_radius = std::max(greatest_radius, tile.radius_m[v]);
    for (const std::uint32_t node : halved[v]) {
      if (node == kNone) continue;
      for (const std::int32_t part : {tile.nodes[node].child, tile.nodes[node].child + 1}) {
        node_place[static_cast<std::size_t>(part)] = static_cast<std::uint32_t>(node_order.size());
        node_order.push_back(static_cast<std::uint32_t>(part));
      }
    }
  }
  tile.bands.push_back({static_cast<std::uint32_t>(order.size()), static_cast<std::uint32_t>(node_order.size()),
                        greatest_error, greatest_radius});
  for (TerrainMesh::Node& node : tile.nodes) {
    if (node.child < 0) continue;
    node.child = static_cast<std::int32_t>(node_place[static_cast<std::size_t>(node.child)]);
    node.middle = place[node.middle];
  }
  permute(tile.nodes, node_order);
  permute(tile.positions_m, order);
  permute(tile.normals, order);
  permute(tile.road_m, order);
  permute(tile.error_m, order);
  permute(tile.radius_m, order);
  for (auto& root : tile.roots) {
    for (std::uint32_t& v : root) v = place[v];
  }
  for (std::uint32_t& v : tile.triangles) v = place[v];
  std::vector<std::uint32_t> all;
  select_triangles(view_of(tile), static_cast<std::uint32_t>(tile.bands.size()), {}, all);
  std::copy(all.begin(), all.end(), tile.triangles.begin());
}

DetailGap gap_of(const GroundTile& tile, std::uint32_t bands) {
  DetailGap gap{glm::dvec2(tile.origin_m) + glm::dvec2(tile.low_m), glm::dvec2(tile.origin_m) + glm::dvec2(tile.high_m),
                tile.bands[bands].error_m, 0};
  for (std::size_t i = bands; i < tile.bands.size(); ++i) {
    gap.radius_m = std::max(gap.radius_m, static_cast<double>(tile.bands[i].radius_m));
  }
  return gap;
}

std::uint32_t bands_needed(const GroundTile& tile, const Detail& detail) {
  auto count = static_cast<std::uint32_t>(tile.bands.size());
  if (detail.part <= 0) return count;
  const double away = glm::length(tile.center_m() - detail.eye_m) - tile.radius_m() - detail.room_m;
  const auto is_needed = [&](const TerrainMesh::Band& band) {
    return band.error_m > detail.part * std::max(away - band.radius_m, 0.0);
  };
  while (count > 1 && !is_needed(tile.bands[count - 1])) --count;
  return count;
}

namespace {

// The way down a tile, from near to far.
class Selection {
 public:
  Selection(const GroundTile& tile, std::uint32_t bands, const Detail& detail, Horizon* horizon,
            std::vector<std::uint32_t>& triangles)
      : tile_(tile),
        detail_(detail),
        known_(tile.bands[bands - 1].vertices),
        eye_(detail.eye_m - tile.origin_m),
        sees_from_((horizon ? horizon->eye_m() : detail.eye_m) - tile.origin_m),
        horizon_(horizon),
        triangles_(triangles) {
    // Those that some of its vertices may reach.
    const glm::dvec2 low = glm::dvec2(tile.origin_m) + glm::dvec2(tile.low_m);
    const glm::dvec2 high = glm::dvec2(tile.origin_m) + glm::dvec2(tile.high_m);
    std::copy_if(detail.gaps.begin(), detail.gaps.end(), std::back_inserter(gaps_), [&](const DetailGap& gap) {
      return glm::length(glm::max(glm::max(gap.low_m - high, low - gap.high_m), glm::dvec2(0))) <= gap.radius_m;
    });
  }

  using Corners = std::array<std::uint32_t, 3>;  // apex, left, right
  // Height of the lowest that was drawn there, from the tile's origin; infinity, negative, if not all was.
  double visit(std::int32_t at, const Corners& c) {
    constexpr double kNotAll = -std::numeric_limits<double>::infinity();
    const TerrainMesh::Node& node = tile_.nodes[static_cast<std::size_t>(at)];
    const bool is_cut = node.child == TerrainMesh::Node::kCut;
    const bool is_leaf = node.child < 0 || (detail_.part > 0 && !is_kept(node.middle));
    Horizon::Sight sight;
    if (horizon_ && horizon_->is_on()) {
      sight = horizon_->sight(flat(c[0]), flat(c[1]), flat(c[2]));
      if (is_cut) horizon_->open(sight);
      // No part of it is further above its corners than it is from the mesh.
      const double beyond = is_leaf ? 0 : tile_.vertex_error_m[node.middle];
      if (!is_cut && horizon_->hides(sight, tile_.origin_m.z + std::max({z(c[0]), z(c[1]), z(c[2])}) + beyond)) {
        return kNotAll;
      }
    }
    if (is_cut) return kNotAll;
    double lowest = std::min({z(c[0]), z(c[1]), z(c[2])});
    if (is_leaf) {
      triangles_.insert(triangles_.end(), c.begin(), c.end());
      if (horizon_ && sight.is_about_eye && is_below(c)) horizon_->disable();
    } else {
      // The half on the eye's side of the line between them first.
      const Corners left{node.middle, c[0], c[1]}, right{node.middle, c[2], c[0]};
      const glm::dvec2 apex(tile_.positions_m[c[0]]), line = glm::dvec2(tile_.positions_m[node.middle]) - apex;
      const bool is_right_near = line.x * (sees_from_.y - apex.y) - line.y * (sees_from_.x - apex.x) > 0;
      const double near = is_right_near ? visit(node.child + 1, right) : visit(node.child, left);
      lowest = std::min(near, is_right_near ? visit(node.child, left) : visit(node.child + 1, right));
    }
    if (horizon_ && lowest > kNotAll) horizon_->add(sight, tile_.origin_m.z + lowest);
    return lowest;
  }

 private:
  double z(std::uint32_t v) const { return tile_.positions_m[v].z; }
  glm::dvec2 flat(std::uint32_t v) const { return glm::dvec2(tile_.origin_m) + glm::dvec2(tile_.positions_m[v]); }
  bool is_out(std::uint32_t v, const DetailGap& gap) const {
    if (tile_.vertex_error_m[v] > gap.error_m) return false;
    const glm::dvec2 at = flat(v);
    return glm::length(at - glm::clamp(at, gap.low_m, gap.high_m)) + tile_.vertex_radius_m[v] <= gap.radius_m;
  }
  bool is_kept(std::uint32_t v) const {
    if (v >= known_) return false;
    const double away =
        glm::length(glm::dvec3(tile_.positions_m[v]) - eye_) - tile_.vertex_radius_m[v] - detail_.room_m;
    if (!(tile_.vertex_error_m[v] > detail_.part * std::max(away, 0.0))) return false;
    return std::none_of(gaps_.begin(), gaps_.end(), [&](const DetailGap& gap) { return is_out(v, gap); });
  }
  // Whether the eye is not above the triangle that it is over or under.
  bool is_below(const Corners& c) const {
    const glm::dvec3 a(tile_.positions_m[c[0]]),
        normal = glm::cross(glm::dvec3(tile_.positions_m[c[1]]) - a, glm::dvec3(tile_.positions_m[c[2]]) - a);
    return !(glm::dot(normal, sees_from_ - a) > 0);
  }

  const GroundTile& tile_;
  const Detail& detail_;
  std::vector<DetailGap> gaps_;
  std::uint32_t known_;
  glm::dvec3 eye_, sees_from_;  // from the tile's origin
  Horizon* horizon_;
  std::vector<std::uint32_t>& triangles_;
};

}  // namespace

void select_triangles(const GroundTile& tile, std::uint32_t bands, const Detail& detail,
                      std::vector<std::uint32_t>& triangles, Horizon* horizon) {
  triangles.clear();
  Selection selection(tile, bands, detail, horizon, triangles);
  // The eye's side of the tile's diagonal first; root 0 lies to the right of it.
  const glm::dvec2 low = glm::dvec2(tile.positions_m[tile.roots[0][2]]),
                   diagonal = glm::dvec2(tile.positions_m[tile.roots[0][1]]) - low;
  const glm::dvec2 eye = glm::dvec2((horizon ? horizon->eye_m() : detail.eye_m) - tile.origin_m) - low;
  const std::size_t near = diagonal.x * eye.y - diagonal.y * eye.x > 0 ? 1 : 0;
  for (const std::size_t root : {near, 1 - near}) selection.visit(static_cast<std::int32_t>(root), tile.roots[root]);
}

}  // namespace roadgen
