#include "roadgen/geodesy/local_frame.h"

#include <GeographicLib/LocalCartesian.hpp>

namespace roadgen {

struct LocalFrame::Impl {
  GeographicLib::LocalCartesian frame;
};

LocalFrame::LocalFrame(const Georeference& origin)
    : impl_(std::make_unique<Impl>(
          Impl{GeographicLib::LocalCartesian(origin.latitude_deg, origin.longitude_deg, origin.height_m)})) {}

LocalFrame::~LocalFrame() = default;
LocalFrame::LocalFrame(LocalFrame&&) noexcept = default;
LocalFrame& LocalFrame::operator=(LocalFrame&&) noexcept = default;

glm::dvec3 LocalFrame::to_local_m(const Geodetic& point) const {
  glm::dvec3 p;
  impl_->frame.Forward(point.latitude_deg, point.longitude_deg, point.height_m, p.x, p.y, p.z);
  return p;
}

Geodetic LocalFrame::to_geodetic(glm::dvec3 p) const {
  Geodetic point;
  impl_->frame.Reverse(p.x, p.y, p.z, point.latitude_deg, point.longitude_deg, point.height_m);
  return point;
}

double length_distortion(double distance_m) {
  const double angle = distance_m / kEarthRadius_m;
  return angle * angle / 2;
}

}  // namespace roadgen
