#include "roadgen/geodesy/local_frame.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <cassert>
#include <cmath>
#include <mutex>
#include <optional>

#include "roadgen/geodesy/projection.h"

namespace roadgen {

struct LocalFrame::Impl {
  GeographicLib::LocalCartesian frame;
  Georeference reference;
  glm::dvec2 ahead{1, 0};  // the network's x axis in the projection
  std::mutex turn;
  std::optional<Projection> projection;
};

LocalFrame::LocalFrame(const Georeference& origin) : impl_(std::make_unique<Impl>()) {
  impl_->reference = origin;
  if (origin.projection.empty()) {
    impl_->frame.Reset(origin.latitude_deg, origin.longitude_deg, origin.height_m);
    return;
  }
  impl_->ahead = {std::cos(origin.offset_heading_rad), std::sin(origin.offset_heading_rad)};
  Result<Projection> projection = Projection::make(origin.projection);
  assert(projection);
  if (projection) impl_->projection = std::move(*projection);
}

LocalFrame::~LocalFrame() = default;
LocalFrame::LocalFrame(LocalFrame&&) noexcept = default;
LocalFrame& LocalFrame::operator=(LocalFrame&&) noexcept = default;

glm::dvec3 LocalFrame::to_local_m(const Geodetic& point) const {
  glm::dvec3 p;
  if (!impl_->projection) {
    impl_->frame.Forward(point.latitude_deg, point.longitude_deg, point.height_m, p.x, p.y, p.z);
    return p;
  }
  const std::lock_guard lock(impl_->turn);
  const glm::dvec2 plane = impl_->projection->to_plane_m({point.longitude_deg, point.latitude_deg});
  const glm::dvec2 d = plane - impl_->reference.offset_m, x = impl_->ahead;
  return {d.x * x.x + d.y * x.y, d.y * x.x - d.x * x.y, point.height_m - impl_->reference.height_m};
}

Geodetic LocalFrame::to_geodetic(glm::dvec3 p) const {
  Geodetic point;
  if (!impl_->projection) {
    impl_->frame.Reverse(p.x, p.y, p.z, point.latitude_deg, point.longitude_deg, point.height_m);
    return point;
  }
  const glm::dvec2 x = impl_->ahead;
  const std::lock_guard lock(impl_->turn);
  const glm::dvec2 degrees = impl_->projection->to_degrees(impl_->reference.offset_m +
                                                           glm::dvec2(p.x * x.x - p.y * x.y, p.x * x.y + p.y * x.x));
  return {degrees.y, degrees.x, p.z + impl_->reference.height_m};
}

Status check_georeference(const Georeference& g) {
  if (!(std::abs(g.latitude_deg) <= 90 && std::abs(g.longitude_deg) <= 180 && std::isfinite(g.height_m))) {
    return Error{ErrorCode::kData, "the origin is not a latitude and longitude in degrees"};
  }
  if (g.projection.empty()) return Done{};
  if (!std::isfinite(g.offset_m.x + g.offset_m.y + g.offset_heading_rad)) {
    return Error{ErrorCode::kData, "the offset is not finite"};
  }
  const Result<Projection> projection = Projection::make(g.projection);
  return projection ? Status(Done{}) : Status(projection.error());
}

double length_distortion(double distance_m) {
  const double angle = distance_m / kEarthRadius_m;
  return angle * angle / 2;
}

}  // namespace roadgen
