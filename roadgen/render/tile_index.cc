#include "roadgen/render/tile_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr int kStack = 64;  // the tree is balanced, its depth at most log2(2^32)

}  // namespace

TileIndex::TileIndex(std::span<const RoadTile> tiles) {
  if (tiles.empty()) return;
  for (const RoadTile& tile : tiles) {
    cells_.push_back(tile.origin_m / kTileSize_m);
  }
  std::vector<std::uint32_t> order(tiles.size());
  std::iota(order.begin(), order.end(), 0u);
  struct Range {
    std::uint32_t node, first, count;
  };
  nodes_.emplace_back();
  for (std::vector<Range> open{{0, 0, static_cast<std::uint32_t>(tiles.size())}}; !open.empty();) {
    const Range range = open.back();
    open.pop_back();
    const auto begin = order.begin() + range.first, end = begin + range.count;
    Bounds box, cells;
    for (auto at = begin; at != end; ++at) {
      box.add(tiles[*at].bounds.low_m);
      box.add(tiles[*at].bounds.high_m);
      cells.add(cells_[*at]);
    }
    Node& node = nodes_[range.node];
    node = {box.low_m, box.high_m, *begin, true};
    if (range.count == 1) continue;
    // At the median of the longest side.
    const glm::dvec3 size = cells.high_m - cells.low_m;
    const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
    const std::uint32_t left = range.count / 2, child = static_cast<std::uint32_t>(nodes_.size());
    std::nth_element(begin, begin + left, end, [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(cells_[a][axis], a) < std::pair(cells_[b][axis], b);
    });
    node.first = child;
    node.is_leaf = false;
    nodes_.resize(nodes_.size() + 2);
    open.push_back({child, range.first, left});
    open.push_back({child + 1, range.first + left, range.count - left});
  }
}

void TileIndex::select(const TileView& view, std::vector<std::uint32_t>& visible) const {
  visible.clear();
  if (nodes_.empty()) return;
  const glm::dvec3 eye = view.camera.position_m;
  Camera endless = view.camera;
  endless.far_m = std::numeric_limits<double>::infinity();
  const Frustum frustum(endless, static_cast<double>(view.width) / view.height);
  const glm::dvec3 forward = view_axes(view.camera).forward;
  std::uint32_t stack[kStack];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const glm::dvec3 low = node.low_m - eye, high = node.high_m - eye;
    const glm::dvec3 room = room_m(view, low, high);
    if (!frustum.may_see(low - room, high + room)) continue;
    // The far plane needs no room: it is a wish, not the picture's border.
    const glm::dvec3 nearest(forward.x > 0 ? low.x : high.x, forward.y > 0 ? low.y : high.y,
                             forward.z > 0 ? low.z : high.z);
    if (glm::dot(forward, nearest) > view.camera.far_m) continue;
    // A box contributes at least as much as any within it.
    if (view.least_contribution > 0 && contribution(view, low, high) < view.least_contribution) continue;
    if (node.is_leaf) {
      visible.push_back(node.first);
    } else {
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
    }
  }
  sort(view, visible);
}

void TileIndex::select_all(const TileView& view, std::vector<std::uint32_t>& visible) const {
  visible.resize(cells_.size());
  std::iota(visible.begin(), visible.end(), 0u);
  sort(view, visible);
}

void TileIndex::sort(const TileView& view, std::vector<std::uint32_t>& tiles) const {
  const glm::dvec3 eye = glm::floor(view.camera.position_m / kTileSize_m);
  std::vector<std::pair<double, std::uint32_t>> keys;
  keys.reserve(tiles.size());
  for (const std::uint32_t tile : tiles) {
    const glm::dvec3 steps = glm::abs(cells_[tile] - eye);
    keys.emplace_back(-(steps.x + steps.y + steps.z), tile);
  }
  std::sort(keys.begin(), keys.end());
  std::transform(keys.begin(), keys.end(), tiles.begin(), [](const auto& key) { return key.second; });
}

glm::dvec3 TileIndex::room_m(const TileView& view, glm::dvec3 low_m, glm::dvec3 high_m) {
  const double pixel = 2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360) / view.height;
  const double away = glm::length(glm::max(-low_m, high_m));
  const double sine = std::max(std::max({low_m.z, -high_m.z, 0.0}) / away, kLeastSine);
  const double room = std::clamp(kEdgeRoom_px * pixel * away / sine, 0.02, kGreatestRoom_m);
  // Beside the road by the room; ahead by it and by what the joint's line, which leans by at most 45 degrees, then runs;
  // up by as many pixels and a grade of one half.
  const double plane = std::sqrt(5.0) * room;
  return {plane, plane, 0.5 * plane + kEdgeRoom_px * pixel * away};
}

double TileIndex::contribution(const TileView& view, glm::dvec3 low_m, glm::dvec3 high_m) {
  // A point P is e above or below P0 at the eye's height. Its picture is off P0's by e / depth(P) across and up, tilted
  // by at most |P0| / depth(P0): reach <= e |P0| / (depth(P) depth(P0)). All of these over the box and its shadow at the
  // eye's height.
  const glm::dvec3 low(low_m.x, low_m.y, std::min(low_m.z, 0.0)), high(high_m.x, high_m.y, std::max(high_m.z, 0.0));
  const glm::dvec3 forward = view_axes(view.camera).forward;
  const glm::dvec3 nearest(forward.x > 0 ? low.x : high.x, forward.y > 0 ? low.y : high.y,
                           forward.z > 0 ? low.z : high.z);
  const double depth = glm::dot(forward, nearest);
  if (depth <= 0) return 1;
  const double e = std::max(-low.z, high.z);
  const glm::dvec2 far = glm::max(-glm::dvec2(low), glm::dvec2(high));
  const double pixel = 2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360) / view.height;
  const double reach = e * glm::length(far) / (depth * depth * pixel);
  const double distance = glm::length(glm::max(glm::max(low_m, -high_m), 0.0));
  return std::min(1.0, reach) * haze_contrast(std::exp(-distance / view.haze_range_m));
}

}  // namespace roadgen
