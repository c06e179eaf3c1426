// GeographicLib's grids of geoid undulations (.pgm): heights above the ellipsoid are those above the geoid plus N.
#pragma once

#include <memory>
#include <string>

#include "roadgen/road/result.h"

namespace roadgen {

class GeoidFile {
 public:
  // Errors: kParse where the file is missing or is none of these grids.
  static Result<GeoidFile> open(const std::string& path);

  // N in metres, by cubic interpolation. One thread at a time. Source: GeographicLib::Geoid.
  double undulation_m(double longitude_deg, double latitude_deg) const;

  ~GeoidFile();
  GeoidFile(GeoidFile&&) noexcept;
  GeoidFile& operator=(GeoidFile&&) noexcept;

 private:
  struct Impl;
  explicit GeoidFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace roadgen
