// Measured elevation: a digital elevation model read from a file, with its voids filled, and its heights by latitude
// and longitude or by its own plane coordinates.
#pragma once

#include <memory>
#include <string>

#include <glm/vec2.hpp>

#include "roadgen/road/result.h"
#include "terrain/grid.h"
#include "terrain/vertical_datum.h"

namespace roadgen {

enum class Interpolation { kBilinear, kBicubic };

// What the numbers of a raster mean. The two colour encodings are those of web map tiles (red, green and blue bytes):
// Terrain-RGB is -10000 m + 0.1 m (65536 r + 256 g + b), where black and transparent pixels are voids; Terrarium is
// 256 r + g + b / 256 - 32768 m, where transparent ones are. Sources: Mapbox; Tilezen Joerd.
enum class HeightEncoding { kHeights, kTerrainRgb, kTerrarium };
// "heights", "terrain-rgb" or "terrarium". Errors: kUsage.
Result<HeightEncoding> height_encoding_from_name(const std::string& name);

// Low and high corner; (longitude, latitude) in degrees, or (x, y) in metres for a model without an Earth reference.
struct Extent {
  glm::dvec2 low{0, 0}, high{0, 0};
  bool contains(glm::dvec2 p) const { return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y; }
};

// Immutable after open(); any number of threads may sample.
class Elevation {
 public:
  // Reads any raster that GDAL reads: GeoTIFF, ESRI ASCII grid, SRTM .hgt, VRT mosaics of many, and the same inside a
  // .zip (the first member that is a raster). Heights in feet become metres by the band's unit; scale and offset are
  // applied. Voids (the file's no-data value, -32768, not finite, with a diagnostic below -12 km or above 9 km) are filled from around them, see fill_holes.
  // Heights above the geoid or the ellipsoid become those of the roads' datum where both are known, post by post; what they
  // were and are is told (datum(), vertical_datum(), a diagnostic). Of SRTM's .hgt files, which do not say it, they are above
  // the geoid EGM96.
  // An image without a place whose path ends in zoom/x/y is a tile of the web map's Mercator grid.
  // A file without a coordinate system whose extent fits into [-180, 180] x [-90, 90] is taken for WGS84 longitude and
  // latitude, with a diagnostic; any other is taken for a plane in metres.
  // Errors: not readable; rotated raster; nothing but voids; fewer than 2 x 2 posts; more than 2^28 posts; colours where
  // heights are said to be, or the other way round; heights in another datum than the roads' and no grid of the geoid there.
  static Result<Elevation> open(const std::string& path, Diagnostics* diagnostics = nullptr,
                                HeightEncoding encoding = HeightEncoding::kHeights, const HeightDatum& datum = {});

  ~Elevation();
  Elevation(Elevation&&) noexcept;
  Elevation& operator=(Elevation&&) noexcept;

  // True where the model has a place on the Earth, so that it is sampled by longitude and latitude.
  bool is_geographic() const;

  // Height in metres at (longitude, latitude) in degrees where is_geographic(), else at (x, y) in metres. Outside the
  // model that of the nearest place of its border. Default: bicubic. Cost: O(1); a model in a projection pays for one
  // transformation by PROJ, one thread at a time.
  double height_m(glm::dvec2 place, Interpolation interpolation = Interpolation::kBicubic) const;

  // False beyond the outermost posts.
  bool covers(glm::dvec2 place) const;

  // Whether all of the four posts about the place are heights of the file, not filled voids, and it is not outside.
  bool is_measured(glm::dvec2 place) const;

  // The places of the outermost posts; for a model in a projection, the box around them.
  Extent extent() const;

  // Distance of neighbouring posts in metres (the smaller of the two directions).
  double post_spacing_m() const;

  // Name of the vertical coordinate system that the file states, or empty.
  const std::string& vertical_datum() const;
  // What the heights told here are measured from; the roads' where nothing is known.
  VerticalDatum datum() const;
  const std::string& path() const;
  std::size_t voids_filled() const;
  // The posts as read and filled, in the file's own coordinates, first row southernmost.
  const Grid& posts() const;

 private:
  struct Impl;
  explicit Elevation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Writes heights on a longitude/latitude grid (degrees, WGS84) as a GeoTIFF of 32-bit floats, whole or not at all. What they
// are measured from is in its coordinate system where it is known: 3D, or compound with the geoid of that name, EGM96 where
// that is empty. Errors: not writable.
Status write_geotiff(const Grid& heights, const std::string& path, VerticalDatum datum = VerticalDatum::kUnknown,
                     const std::string& geoid = {});

}  // namespace roadgen
