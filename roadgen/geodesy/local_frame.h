// The frame of a network on the Earth: topocentric east, north, up about an origin on the WGS84 ellipsoid, or the plane
// of a map's projection.
#pragma once

#include <glm/vec3.hpp>
#include <memory>

#include "roadgen/road/network.h"

namespace roadgen {

// Latitude and longitude in degrees on WGS84, height in metres above the ellipsoid.
struct Geodetic {
  double latitude_deg = 0, longitude_deg = 0, height_m = 0;
};

// Changes of coordinates, exact to nanometres near the origin. The topocentric frame is Cartesian: z is height above the
// tangent plane at the origin, not above the ellipsoid, so z falls short of the height by d^2 / 2R at distance d (0.2 m
// at 1.6 km, 7.8 m at 10 km); horizontal lengths at d are seen shortened by up to d^2 / 2R^2 (see length_distortion).
// Source: GeographicLib::LocalCartesian.
//
// In a projection z is the height above height_m, lengths are those of the projection, and what PROJ knows of the datum is
// applied to latitude and longitude; positions where it is not defined come as infinite.
// Source: PROJ; ASAM OpenDRIVE 1.7, clause 8.5, for the offset.
class LocalFrame {
 public:
  // Requires: check_georeference(origin).
  explicit LocalFrame(const Georeference& origin);
  ~LocalFrame();
  LocalFrame(LocalFrame&&) noexcept;
  LocalFrame& operator=(LocalFrame&&) noexcept;

  // From any number of threads, which take turns in a projection.
  glm::dvec3 to_local_m(const Geodetic& point) const;
  Geodetic to_geodetic(glm::dvec3 point_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Whether the origin is a place on the Earth, and the projection, where there is one, a projected system in metres that
// PROJ knows: a PROJ string, WKT or "EPSG:CODE". Errors: kData with what is wrong; kIo where PROJ, which is loaded for
// projections alone, is missing.
Status check_georeference(const Georeference& georeference);

// Mean radius of the Earth (IUGG), for estimates.
inline constexpr double kEarthRadius_m = 6371008.8;

// The part by which a level horizontal length at distance_m from the origin may appear shortened in the topocentric frame.
double length_distortion(double distance_m);

}  // namespace roadgen
