#include "terrain/local_frame.h"

#include <GeographicLib/LocalCartesian.hpp>

namespace roadgen {

struct LocalFrame::Impl {
  GeographicLib::LocalCartesian frame;
};

LocalFrame::LocalFrame(const Georeference& origin)
    : impl_(new Impl{GeographicLib::LocalCartesian(origin.latitude_deg, origin.longitude_deg, origin.height_m)}) {}
LocalFrame::~LocalFrame() = default;
LocalFrame::LocalFrame(LocalFrame&&) noexcept = default;
LocalFrame& LocalFrame::operator=(LocalFrame&&) noexcept = default;

glm::dvec3 LocalFrame::to_enu_m(const Geodetic& place) const {
  glm::dvec3 p;
  impl_->frame.Forward(place.latitude_deg, place.longitude_deg, place.height_m, p.x, p.y, p.z);
  return p;
}

Geodetic LocalFrame::to_geodetic(glm::dvec3 enu_m) const {
  Geodetic g;
  impl_->frame.Reverse(enu_m.x, enu_m.y, enu_m.z, g.latitude_deg, g.longitude_deg, g.height_m);
  return g;
}

}  // namespace roadgen
