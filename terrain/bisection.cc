#include "terrain/bisection.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

}  // namespace

Bisection::Bisection(glm::ivec2 tiles, int k, Height height) : tiles_(tiles), k_(k), height_(std::move(height)) {
  assert(tiles.x >= 1 && tiles.y >= 1 && k >= 1 && k <= 14);
  for (int y = 0; y <= tiles.y; ++y) {
    for (int x = 0; x <= tiles.x; ++x) {
      lattice_.push_back(glm::ivec2(x, y) * cells());
      heights_.push_back(height_(lattice_.back()));
    }
  }
  // The diagonal of a tile runs from its low to its high corner; triangle 0 lies below it, triangle 1 above.
  const auto corner = [&](int x, int y) { return static_cast<std::uint32_t>(y * (tiles.x + 1) + x); };
  const auto root = [&](int x, int y, int which) {
    return x < 0 || y < 0 || x >= tiles.x || y >= tiles.y ? -1 : 2 * (y * tiles.x + x) + which;
  };
  for (int y = 0; y < tiles.y; ++y) {
    for (int x = 0; x < tiles.x; ++x) {
      triangles_.push_back({corner(x + 1, y), corner(x + 1, y + 1), corner(x, y), root(x, y, 1), root(x + 1, y, 1),
                            root(x, y - 1, 1), 0});
      triangles_.push_back({corner(x, y + 1), corner(x, y), corner(x + 1, y + 1), root(x, y, 0), root(x - 1, y, 0),
                            root(x, y + 1, 0), 0});
    }
  }
  leaves_ = triangles_.size();
  child_.assign(leaves_, -1);
}

Bisection::Bisection(glm::ivec2 tiles, int k, Kept kept)
    : tiles_(tiles),
      k_(k),
      leaves_(static_cast<std::size_t>(std::count(kept.child.begin(), kept.child.end(), -1))),
      triangles_(std::move(kept.triangles)),
      child_(std::move(kept.child)),
      lattice_(std::move(kept.lattice)),
      heights_(std::move(kept.heights)) {}

bool Bisection::refine(const Wanted& wanted, std::size_t most_triangles) {
  // Wave by wave: what is wanted of the triangles so far, then the splits, whose children and forced neighbours are the
  // next wave, then the heights of the new vertices. The splits depend on no order, so neither does the mesh.
  std::vector<std::uint8_t> split_it;
  for (std::size_t begin = 0; begin < triangles_.size();) {
    const std::size_t end = triangles_.size(), known = lattice_.size();
    split_it.assign(end - begin, 0);
    for_each_index(end - begin, [&](std::size_t i) {
      const Triangle& t = triangles_[begin + i];
      split_it[i] = child_[begin + i] < 0 && t.level < 2 * k_ && wanted(t);
    });
    for (std::size_t i = begin; i < end; ++i) {
      if (split_it[i - begin] && child_[i] < 0) split(static_cast<std::int32_t>(i));
    }
    if (leaves_ > most_triangles) return false;
    heights_.resize(lattice_.size());
    for_each_index(lattice_.size() - known, [&](std::size_t i) { heights_[known + i] = height_(lattice_[known + i]); });
    begin = end;
  }
  return true;
}

void Bisection::relink(std::int32_t neighbour, std::int32_t from, std::int32_t to) {
  if (neighbour < 0) return;
  Triangle& t = at(neighbour);
  if (t.across_base == from)
    t.across_base = to;
  else if (t.across_left == from)
    t.across_left = to;
  else if (t.across_right == from)
    t.across_right = to;
}

void Bisection::split(std::int32_t i) {
  // A larger neighbour at the hypotenuse has it as a leg: it is refined first, and its child takes its place.
  const std::int32_t before = at(i).across_base;
  if (before >= 0 && at(before).across_base != i) split(before);
  const std::int32_t partner = at(i).across_base;
  assert(partner < 0 || at(partner).across_base == i);

  const auto middle = static_cast<std::uint32_t>(lattice_.size());
  lattice_.push_back((lattice_[at(i).left] + lattice_[at(i).right]) / 2);
  halve(i, middle);
  if (partner < 0) return;
  halve(partner, middle);
  const auto mine = child_[static_cast<std::size_t>(i)], other = child_[static_cast<std::size_t>(partner)];
  at(mine).across_right = other + 1;
  at(other + 1).across_left = mine;
  at(mine + 1).across_left = other;
  at(other).across_right = mine + 1;
}

// Two children: the left one stands on the left leg, the right one on the right leg; both have the middle as apex.
void Bisection::halve(std::int32_t i, std::uint32_t middle) {
  const Triangle t = at(i);
  const auto child = static_cast<std::int32_t>(triangles_.size());
  triangles_.push_back({middle, t.apex, t.left, t.across_left, child + 1, -1, t.level + 1});
  triangles_.push_back({middle, t.right, t.apex, t.across_right, -1, child, t.level + 1});
  child_.insert(child_.end(), 2, -1);
  child_[static_cast<std::size_t>(i)] = child;
  relink(t.across_left, i, child);
  relink(t.across_right, i, child + 1);
  ++leaves_;
}

glm::dvec2 Bisection::clamped(glm::dvec2 place) const {
  const double width = static_cast<double>(tiles_.x) * cells(), depth = static_cast<double>(tiles_.y) * cells();
  return {std::clamp(place.x, 0.0, width), std::clamp(place.y, 0.0, depth)};
}

Bisection::Found Bisection::found(glm::dvec2 place) const {
  const int x = std::min(static_cast<int>(place.x) >> k_, tiles_.x - 1);
  const int y = std::min(static_cast<int>(place.y) >> k_, tiles_.y - 1);
  const glm::ivec2 low(x * cells(), y * cells()), high = low + cells();
  const glm::dvec2 inside = place - glm::dvec2(low);
  const bool above = inside.y > inside.x;
  Found f{2 * (y * tiles_.x + x) + (above ? 1 : 0), {above ? low.x : high.x, above ? high.y : low.y}, high, low};
  if (above) std::swap(f.left, f.right);
  for (;;) {
    const std::int32_t child = child_[static_cast<std::size_t>(f.leaf)];
    if (child < 0) return f;
    const glm::ivec2 middle = (f.left + f.right) / 2, apex = f.apex;
    // The left vertex lies to the right of the ray from the apex to the middle.
    const bool to_left = cross(glm::dvec2(middle - apex), place - glm::dvec2(apex)) < 0;
    f = to_left ? Found{child, middle, apex, f.left} : Found{child + 1, middle, f.right, apex};
  }
}

std::int32_t Bisection::find(glm::dvec2 place) const { return found(clamped(place)).leaf; }

double Bisection::height_at(glm::dvec2 place) const {
  place = clamped(place);
  const Found f = found(place);
  const Triangle& t = triangle(f.leaf);
  const glm::dvec2 apex(f.apex), left = glm::dvec2(f.left) - apex, right = glm::dvec2(f.right) - apex;
  const double area = cross(left, right);
  const double to_left = cross(place - apex, right) / area, to_right = cross(left, place - apex) / area;
  return heights_[t.apex] + to_left * (heights_[t.left] - heights_[t.apex]) +
         to_right * (heights_[t.right] - heights_[t.apex]);
}

glm::dvec2 Bisection::gradient(std::int32_t leaf) const {
  const Triangle& t = triangle(leaf);
  const glm::dvec2 left(lattice_[t.left] - lattice_[t.apex]), right(lattice_[t.right] - lattice_[t.apex]);
  const double to_left = heights_[t.left] - heights_[t.apex], to_right = heights_[t.right] - heights_[t.apex];
  return glm::dvec2(to_left * right.y - to_right * left.y, to_right * left.x - to_left * right.x) / cross(left, right);
}

}  // namespace roadgen
