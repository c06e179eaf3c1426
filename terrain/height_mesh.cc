#include "terrain/height_mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "terrain/bisection.h"

namespace roadgen {
namespace {

// A tile's side: as fine as a double tells places within it.
constexpr std::int64_t kOne = std::int64_t{1} << 52;
// Halvings whose nodes lie together, so that the way down crosses few cache lines.
constexpr int kTogether = 4;

struct Laid {
  std::vector<std::int32_t> nodes;
  std::vector<HeightMesh::Leaf> leaves;
};

// Lays out what hangs from a triangle of the mesh, whose own node is at `place`.
void lay(const Bisection& mesh, double quantum_m, std::int32_t triangle, std::size_t place, Laid& laid) {
  struct Pending {
    std::int32_t triangle;
    std::size_t place;
  };
  const auto quanta = [&](std::uint32_t v) {
    return static_cast<std::int32_t>(std::llround(mesh.height(v) / quantum_m));
  };
  std::vector<Pending> roots{{triangle, place}}, level, next;
  while (!roots.empty()) {
    level.assign(1, roots.back());
    roots.pop_back();
    for (int i = 0; i < kTogether && !level.empty(); ++i) {
      next.clear();
      for (const Pending& at : level) {
        const std::int32_t child = mesh.child(at.triangle);
        if (child < 0) {
          const Bisection::Triangle& t = mesh.triangle(at.triangle);
          laid.nodes[at.place] = ~static_cast<std::int32_t>(laid.leaves.size());
          laid.leaves.push_back({quanta(t.apex), quanta(t.left), quanta(t.right)});
          continue;
        }
        laid.nodes[at.place] = static_cast<std::int32_t>(laid.nodes.size());
        next.push_back({child, laid.nodes.size()});
        next.push_back({child + 1, laid.nodes.size() + 1});
        laid.nodes.resize(laid.nodes.size() + 2);
      }
      level.swap(next);
    }
    roots.insert(roots.end(), level.rbegin(), level.rend());
  }
}

}  // namespace

HeightMesh::HeightMesh(const Bisection& mesh, double quantum_m)
    : tiles_(mesh.tiles()), k_(mesh.finest() / 2), quantum_m_(quantum_m) {
  const auto laid = std::make_shared<Laid>();
  const std::size_t roots = 2 * static_cast<std::size_t>(tiles_.x) * static_cast<std::size_t>(tiles_.y);
  laid->nodes.reserve(mesh.triangle_count());
  laid->leaves.reserve(mesh.leaves());
  laid->nodes.resize(roots);
  for (std::size_t i = 0; i < roots; ++i) lay(mesh, quantum_m, static_cast<std::int32_t>(i), i, *laid);
  nodes_ = laid->nodes;
  leaves_ = laid->leaves;
  owner_ = laid;
}

HeightMesh::HeightMesh(glm::ivec2 tiles, int k, double quantum_m, std::span<const std::int32_t> nodes,
                       std::span<const Leaf> leaves, std::shared_ptr<const void> owner)
    : tiles_(tiles), k_(k), quantum_m_(quantum_m), nodes_(nodes), leaves_(leaves), owner_(std::move(owner)) {}

bool HeightMesh::is_sound() const {
  const std::size_t roots = 2 * static_cast<std::size_t>(tiles_.x) * static_cast<std::size_t>(tiles_.y);
  if (nodes_.size() < roots || nodes_.size() % 2 != 0) return false;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const std::int32_t node = nodes_[i];
    const auto to = static_cast<std::size_t>(node < 0 ? ~node : node);
    if (node < 0 ? to >= leaves_.size() : to <= i || to < roots || to + 1 >= nodes_.size()) return false;
  }
  return true;
}

HeightMesh::At HeightMesh::start(glm::dvec2 place) const {
  const double cells = static_cast<double>(1 << k_);
  // In tiles; what is no number goes to the corner.
  const double x = std::max(0.0, std::min(place.x / cells, static_cast<double>(tiles_.x)));
  const double y = std::max(0.0, std::min(place.y / cells, static_cast<double>(tiles_.y)));
  const int column = std::min(static_cast<int>(x), tiles_.x - 1), row = std::min(static_cast<int>(y), tiles_.y - 1);
  const auto fx = static_cast<std::int64_t>((x - column) * static_cast<double>(kOne));
  const auto fy = static_cast<std::int64_t>((y - row) * static_cast<double>(kOne));
  const std::int32_t root = 2 * (row * tiles_.x + column);
  return fy > fx ? At{kOne - fy, fx, root + 1} : At{fy, kOne - fx, root};
}

// The conditional is one of values, never a jump: which half it is no processor can guess.
inline std::int32_t HeightMesh::step(At& at) {
  const std::int64_t rest = kOne - at.a - at.b, lead = at.a - at.b;
  const std::int64_t right = -static_cast<std::int64_t>(lead <= 0);  // all bits, or none
  // On the left (rest, lead), on the right (-lead, rest).
  const std::int64_t exchange = (rest ^ -lead) & right;
  const std::int64_t exchange_b = (lead ^ rest) & right;
  at.a = rest ^ exchange;
  at.b = lead ^ exchange_b;
  return static_cast<std::int32_t>(-right);
}

inline double HeightMesh::height_m(const At& at) const {
  const Leaf& leaf = leaves_[static_cast<std::size_t>(~at.node)];
  const double a = static_cast<double>(at.a) / static_cast<double>(kOne);
  const double b = static_cast<double>(at.b) / static_cast<double>(kOne);
  // Differences in 64 bits, which hold them all.
  const double left = static_cast<double>(std::int64_t{leaf.left} - leaf.apex);
  const double right = static_cast<double>(std::int64_t{leaf.right} - leaf.apex);
  return quantum_m_ * (leaf.apex + a * left + b * right);
}

double HeightMesh::height_m(glm::dvec2 place) const {
  At at = start(place);
  at.node = nodes_[static_cast<std::size_t>(at.node)];
  while (at.node >= 0) {
    const std::int32_t first = at.node;
    at.node = nodes_[static_cast<std::size_t>(first + step(at))];
  }
  return height_m(at);
}

void HeightMesh::heights_m(std::span<const glm::dvec2> places, std::span<double> heights_m) const {
  assert(places.size() == heights_m.size());
  std::array<At, kLanes> at;
  for (std::size_t first = 0; first < places.size(); first += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, places.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      at[i] = start(places[first + i]);
      at[i].node = nodes_[static_cast<std::size_t>(at[i].node)];
    }
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < count; ++i) {
        if (at[i].node < 0) continue;
        const std::int32_t node = at[i].node;
        at[i].node = nodes_[static_cast<std::size_t>(node + step(at[i]))];
        more = true;
      }
    }
    for (std::size_t i = 0; i < count; ++i) heights_m[first + i] = height_m(at[i]);
  }
}

glm::dvec2 HeightMesh::gradient(glm::dvec2 place) const {
  At at = start(place);
  const double cells = static_cast<double>(1 << k_);
  // The legs, in lattice units, whose heights are known in the end.
  glm::dvec2 left(0, cells), right(-cells, 0);
  if (at.node % 2 != 0) left = -left, right = -right;
  at.node = nodes_[static_cast<std::size_t>(at.node)];
  while (at.node >= 0) {
    const std::int32_t first = at.node, half = step(at);
    const glm::dvec2 back = -0.5 * (left + right), along = 0.5 * (left - right);
    left = half == 0 ? back : -along;
    right = half == 0 ? along : back;
    at.node = nodes_[static_cast<std::size_t>(first + half)];
  }
  const Leaf& leaf = leaves_[static_cast<std::size_t>(~at.node)];
  const double to_left = static_cast<double>(std::int64_t{leaf.left} - leaf.apex);
  const double to_right = static_cast<double>(std::int64_t{leaf.right} - leaf.apex);
  const double area = left.x * right.y - left.y * right.x;
  return quantum_m_ * glm::dvec2(to_left * right.y - to_right * left.y, to_right * left.x - to_left * right.x) / area;
}

}  // namespace roadgen
