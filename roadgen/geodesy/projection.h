// Coordinate systems of maps, by PROJ. Internal to roadgen/geodesy: LocalFrame is what others use.
#pragma once

#include <memory>
#include <string>

#include <glm/vec2.hpp>

#include "roadgen/road/result.h"

namespace roadgen {

// Between the plane of a projected system, x east and y north in metres, and longitude and latitude in degrees on WGS84.
// One thread at a time.
class Projection {
 public:
  // definition: a PROJ string, WKT, or anything else that PROJ knows, such as "EPSG:25832". The library is loaded when
  // this is first called; with its data base it takes 10 MB and 30 ms.
  // Errors: kData with PROJ's words for what it does not know, and for systems not in metres (longitude and latitude, feet);
  // kIo where the library is missing.
  static Result<Projection> make(const std::string& definition);
  ~Projection();
  Projection(Projection&&) noexcept;
  Projection& operator=(Projection&&) noexcept;

  // Infinite where the projection is not defined.
  glm::dvec2 to_plane_m(glm::dvec2 longitude_latitude_deg);
  glm::dvec2 to_degrees(glm::dvec2 plane_m);

 private:
  struct Impl;
  explicit Projection(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace roadgen
