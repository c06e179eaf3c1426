// What heights are measured from, the geoid (sea level) or the WGS84 ellipsoid, and the undulation between the two: heights
// above the ellipsoid are those above the geoid plus N.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

enum class VerticalDatum { kUnknown, kGeoid, kEllipsoid };
// "geoid", "ellipsoid" or "unknown".
const char* name_of(VerticalDatum datum);

// What the heights of an elevation are, and what they are to become.
struct HeightDatum {
  // Of the elevation. None: as its file says. kUnknown: that of the roads, whatever that is. Default: as the file says
  std::optional<VerticalDatum> own;
  // Of the roads. kUnknown: heights stay as they are. Default: stay
  VerticalDatum roads = VerticalDatum::kUnknown;
  // Undulations on a grid: .gtx, GeoTIFF, or GeographicLib's .pgm. Empty: what PROJ has installed of the file's geoid, or
  // of EGM96 where the file names none.
  std::string geoid_path;
};

// --dem-datum: "file", "geoid", "ellipsoid" or "as-roads". Errors: kUsage.
Result<std::optional<VerticalDatum>> elevation_datum_from_name(const std::string& name);
// --road-datum: "file" (what the georeference says, mostly nothing), "geoid" or "ellipsoid". Errors: kUsage.
Result<VerticalDatum> road_datum_from_name(const std::string& name, const Network& network);

// N over the Earth. One thread at a time.
class Undulation {
 public:
  // vertical: the geoid's vertical coordinate system, as WKT or "EPSG:CODE"; used where geoid_path is empty.
  // Errors: kIo, kParse or kData where the grid cannot be read; kData where PROJ has no grid of the geoid.
  static Result<Undulation> open(const std::string& geoid_path, const std::string& vertical);

  // N in metres at a place on WGS84, in degrees; none outside of the grid. Bilinear between the grid's posts (a .pgm's:
  // cubic, as GeographicLib has it). Cost: about 1 us.
  std::optional<double> at(double longitude_deg, double latitude_deg) const;

  ~Undulation();
  Undulation(Undulation&&) noexcept;
  Undulation& operator=(Undulation&&) noexcept;

 private:
  struct Impl;
  explicit Undulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace roadgen
