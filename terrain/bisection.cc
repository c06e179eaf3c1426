#include "terrain/bisection.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "roadgen/road/parallel.h"

namespace roadgen {

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

}  // namespace roadgen
