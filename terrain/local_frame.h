// The local east-north-up frame of a network on the WGS84 ellipsoid.
#pragma once

#include <memory>

#include <glm/vec3.hpp>

#include "roadgen/road/network.h"

namespace roadgen {

// Latitude and longitude in degrees, height in metres above the ellipsoid (or above whatever the heights of the
// network and of the elevation both mean; the difference tilts nothing and cancels).
struct Geodetic {
  double latitude_deg = 0;
  double longitude_deg = 0;
  double height_m = 0;
};

// Exact, both ways, to 10 nm within 1000 km. Thread-safe. Source: GeographicLib::LocalCartesian (Karney).
class LocalFrame {
 public:
  explicit LocalFrame(const Georeference& origin);
  ~LocalFrame();
  LocalFrame(LocalFrame&&) noexcept;
  LocalFrame& operator=(LocalFrame&&) noexcept;

  glm::dvec3 to_enu_m(const Geodetic& place) const;
  Geodetic to_geodetic(glm::dvec3 enu_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace roadgen
