#include "roadgen/render/object_proxy.h"

#include <cmath>
#include <numbers>

namespace roadgen {
namespace {

using Index = std::uint16_t;

// Around the unit circle, at a height.
void add_polygon(std::vector<glm::vec3>& corners, int sides, float z) {
  for (int i = 0; i < sides; ++i) {
    const double turn = (i + 0.5) * 2 * std::numbers::pi / sides, out = 1 / std::cos(std::numbers::pi / sides);
    corners.push_back(glm::vec3(static_cast<float>(out * std::cos(turn)), static_cast<float>(out * std::sin(turn)), z));
  }
}

// The triangles of a convex polygon in strips from both ends to the middle: short edges, less to draw twice.
void add_fan(std::vector<Index>& elements, int first, int sides, bool reversed) {
  for (int low = 0, high = sides - 1; high - low >= 2;) {
    const auto add = [&](int a, int b, int c) {
      const int order[] = {a, reversed ? c : b, reversed ? b : c};
      for (const int i : order) elements.push_back(static_cast<Index>(first + i));
    };
    add(low, low + 1, high);
    ++low;
    if (high - low >= 2) add(low, high - 1, high), --high;
  }
}

// Corners of which the shader makes its polygon.
ProxyMesh outline(int corners) {
  ProxyMesh mesh;
  for (int i = 0; i < corners; ++i) mesh.corners.push_back(glm::vec3(i, corners, 1));
  add_fan(mesh.elements, 0, corners, false);
  return mesh;
}

// Between the outer and the inner polygon.
ProxyMesh ring(int sides) {
  ProxyMesh mesh;
  for (const int outer : {1, 0}) {
    for (int i = 0; i < sides; ++i) mesh.corners.push_back(glm::vec3(i, sides, outer));
  }
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    for (const int k : {i, next, sides + next, i, sides + next, sides + i}) {
      mesh.elements.push_back(static_cast<Index>(k));
    }
  }
  return mesh;
}

ProxyMesh box() {
  ProxyMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.corners.push_back({i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1});
  mesh.elements = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                   2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return mesh;
}

}  // namespace

ProxyMesh proxy_mesh(Proxy proxy, int sides) {
  switch (proxy) {
    case Proxy::kBox: return box();
    case Proxy::kHull: return {};
    case Proxy::kOutline: return outline(sides);
    case Proxy::kRing: return ring(sides);
    case Proxy::kTetra: {
      const float l = -0.25f, h = 0.75f;
      return {{{l, l, l}, {h, l, l}, {l, h, l}, {l, l, h}}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
    }
    case Proxy::kTriangle: {
      const float l = -1.0f / 3, h = 2.0f / 3;
      return {{{l, l, 0}, {h, l, 0}, {l, h, 0}}, {0, 1, 2}};
    }
    case Proxy::kSquare: sides = 4; [[fallthrough]];
    case Proxy::kPolygon: break;
  }
  ProxyMesh mesh;
  add_polygon(mesh.corners, sides, 0);
  add_fan(mesh.elements, 0, sides, false);
  return mesh;
}

std::vector<Index> polygon_elements(int corners, std::uint32_t count) {
  std::vector<Index> elements;
  for (std::uint32_t i = 0; i < count; ++i) add_fan(elements, static_cast<int>(i) * corners, corners, false);
  return elements;
}

}  // namespace roadgen
