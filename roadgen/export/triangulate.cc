#include "roadgen/export/triangulate.h"

#include <geos_c.h>

#include <memory>
#include <utility>

namespace roadgen {
namespace {

class Geos {
 public:
  Geos() : handle_(GEOS_init_r()) {}
  ~Geos() { GEOS_finish_r(handle_); }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;

  std::vector<std::array<glm::dvec2, 3>> triangles(const std::vector<glm::dvec2>& ring) const {
    GEOSCoordSequence* points = GEOSCoordSeq_create_r(handle_, static_cast<unsigned>(ring.size() + 1), 2);
    for (std::size_t i = 0; i <= ring.size(); ++i) {
      const glm::dvec2 p = ring[i % ring.size()];
      GEOSCoordSeq_setXY_r(handle_, points, static_cast<unsigned>(i), p.x, p.y);
    }
    const auto free = [this](GEOSGeometry* g) { GEOSGeom_destroy_r(handle_, g); };
    using Held = std::unique_ptr<GEOSGeometry, decltype(free)>;
    const Held polygon(GEOSGeom_createPolygon_r(handle_, GEOSGeom_createLinearRing_r(handle_, points), nullptr, 0),
                       free);
    std::vector<std::array<glm::dvec2, 3>> result;
    if (!polygon) return result;
    const Held all(GEOSConstrainedDelaunayTriangulation_r(handle_, polygon.get()), free);
    const int count = all ? GEOSGetNumGeometries_r(handle_, all.get()) : 0;
    for (int i = 0; i < count; ++i) {
      const GEOSGeometry* shell = GEOSGetExteriorRing_r(handle_, GEOSGetGeometryN_r(handle_, all.get(), i));
      const GEOSCoordSequence* corners = GEOSGeom_getCoordSeq_r(handle_, shell);
      std::array<glm::dvec2, 3> t;
      for (unsigned k = 0; k < 3; ++k) GEOSCoordSeq_getXY_r(handle_, corners, k, &t[k].x, &t[k].y);
      const glm::dvec2 a = t[1] - t[0], b = t[2] - t[0];
      if (a.x * b.y - a.y * b.x < 0) std::swap(t[1], t[2]);
      result.push_back(t);
    }
    return result;
  }

 private:
  GEOSContextHandle_t handle_;
};

}  // namespace

std::vector<std::array<glm::dvec2, 3>> triangulated(const std::vector<glm::dvec2>& ring) {
  return Geos().triangles(ring);
}

}  // namespace roadgen
