#include "terrain/bisection.h"

#include <algorithm>
#include <cassert>
#include <cmath>

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
      triangles_.push_back({corner(x + 1, y), corner(x + 1, y + 1), corner(x, y), -1, root(x, y, 1), root(x + 1, y, 1),
                            root(x, y - 1, 1), 0});
      triangles_.push_back({corner(x, y + 1), corner(x, y), corner(x + 1, y + 1), -1, root(x, y, 0), root(x - 1, y, 0),
                            root(x, y + 1, 0), 0});
    }
  }
  leaves_ = triangles_.size();
}

bool Bisection::refine(const Wanted& wanted, std::size_t most_triangles) {
  // Children go to the end of the list, so one walk over it sees every triangle, forced ones too.
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (triangles_[i].child >= 0 || triangles_[i].level >= 2 * k_) continue;
    const Triangle copy = triangles_[i];
    if (!wanted(copy)) continue;
    split(static_cast<std::int32_t>(i));
    if (leaves_ > most_triangles) return false;
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
  heights_.push_back(height_(lattice_.back()));
  halve(i, middle);
  if (partner < 0) return;
  halve(partner, middle);
  const std::int32_t mine = at(i).child, other = at(partner).child;
  at(mine).across_right = other + 1;
  at(other + 1).across_left = mine;
  at(mine + 1).across_left = other;
  at(other).across_right = mine + 1;
}

// Two children: the left one stands on the left leg, the right one on the right leg; both have the middle as apex.
void Bisection::halve(std::int32_t i, std::uint32_t middle) {
  const Triangle t = at(i);
  const auto child = static_cast<std::int32_t>(triangles_.size());
  triangles_.push_back({middle, t.apex, t.left, -1, t.across_left, child + 1, -1, t.level + 1});
  triangles_.push_back({middle, t.right, t.apex, -1, t.across_right, -1, child, t.level + 1});
  at(i).child = child;
  relink(t.across_left, i, child);
  relink(t.across_right, i, child + 1);
  ++leaves_;
}

glm::dvec2 Bisection::clamped(glm::dvec2 place) const {
  const double width = static_cast<double>(tiles_.x) * cells(), depth = static_cast<double>(tiles_.y) * cells();
  return {std::clamp(place.x, 0.0, width), std::clamp(place.y, 0.0, depth)};
}

std::int32_t Bisection::find(glm::dvec2 place) const {
  place = clamped(place);
  const int x = std::min(static_cast<int>(place.x) >> k_, tiles_.x - 1);
  const int y = std::min(static_cast<int>(place.y) >> k_, tiles_.y - 1);
  const glm::dvec2 inside = place - glm::dvec2(x, y) * static_cast<double>(cells());
  std::int32_t i = 2 * (y * tiles_.x + x) + (inside.y > inside.x ? 1 : 0);
  while (triangle(i).child >= 0) {
    const Triangle& t = triangle(i);
    const glm::dvec2 apex(lattice_[t.apex]);
    const glm::dvec2 middle = 0.5 * (glm::dvec2(lattice_[t.left]) + glm::dvec2(lattice_[t.right]));
    // The left vertex lies to the right of the ray from the apex to the middle.
    i = cross(middle - apex, place - apex) < 0 ? t.child : t.child + 1;
  }
  return i;
}

double Bisection::height_on(std::int32_t leaf, glm::dvec2 place) const {
  place = clamped(place);
  const Triangle& t = triangle(leaf);
  const glm::dvec2 apex(lattice_[t.apex]);
  const glm::dvec2 left = glm::dvec2(lattice_[t.left]) - apex, right = glm::dvec2(lattice_[t.right]) - apex;
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

double Bisection::height_at(glm::dvec2 place) const { return height_on(find(place), place); }

std::vector<std::int32_t> Bisection::leaves_of(glm::ivec2 tile) const {
  const std::int32_t root = 2 * (tile.y * tiles_.x + tile.x);
  std::vector<std::int32_t> stack{root, root + 1}, found;
  while (!stack.empty()) {
    const std::int32_t i = stack.back();
    stack.pop_back();
    const std::int32_t child = triangle(i).child;
    if (child < 0) {
      found.push_back(i);
    } else {
      stack.push_back(child);
      stack.push_back(child + 1);
    }
  }
  return found;
}

}  // namespace roadgen
