// Parts for tessellate().
#pragma once

#include <string>
#include <utility>

#include "roadgen/export/mesh.h"

namespace roadgen {

// Gathers the parts of one item.
class MeshBuilder {
 public:
  MeshBuilder(std::string name, glm::dvec3 origin_m) { item_.name = std::move(name), item_.origin_m = origin_m; }

  // The part of that name. Valid until another is asked for.
  MeshPart& part(const std::string& name, glm::dvec3 albedo) {
    for (MeshPart& part : item_.parts) {
      if (part.name == name) return part;
    }
    return item_.parts.emplace_back(MeshPart{name, albedo, {}, {}, {}});
  }
  std::uint32_t vertex(MeshPart& part, glm::dvec3 position_m, glm::dvec3 normal) const {
    part.positions.emplace_back(position_m - item_.origin_m);
    part.normals.emplace_back(normal);
    return static_cast<std::uint32_t>(part.positions.size() - 1);
  }
  // Left out where it has no area.
  void triangle(MeshPart& part, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const glm::vec3 p = part.positions[a], q = part.positions[b], r = part.positions[c];
    if (p == q || q == r || r == p) return;
    part.triangles.insert(part.triangles.end(), {a, b, c});
    ++triangles_;
  }
  void quad(MeshPart& part, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(part, a, b, c);
    triangle(part, a, c, d);
  }
  std::size_t triangles() const { return triangles_; }
  MeshItem take() {
    std::erase_if(item_.parts, [](const MeshPart& part) { return part.triangles.empty(); });
    return std::move(item_);
  }

 private:
  MeshItem item_;
  std::size_t triangles_ = 0;
};

// Adds the junction's area to the mesh. Errors: as tessellate().
Status add_junction(const Junction& junction, double max_error_m, NetworkMesh& mesh);

// Adds the road's sweeps to the mesh. Errors: as tessellate().
Status add_sweeps(const Road& road, double max_error_m, NetworkMesh& mesh);

// A new item where the one at hand begins farther away than this, so that floats hold positions.
inline constexpr double kItemReach_m = 1000;

}  // namespace roadgen
