#include "terrain/elevation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <mutex>
#include <numbers>
#include <optional>

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

namespace roadgen {
namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180;
constexpr double kFoot_m = 0.3048, kSurveyFoot_m = 1200.0 / 3937.0;
// The Earth's ground, with room: what is beyond is a number that overflowed or another unit.
constexpr double kLowest_m = -12000, kHighest_m = 9000;
constexpr std::int64_t kMostPosts = std::int64_t{1} << 28;

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

struct CloseTransformation {
  void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using Transformation = std::unique_ptr<OGRCoordinateTransformation, CloseTransformation>;

// GDAL reports by return values here; its own lines on stderr would say everything twice.
class Quiet {
 public:
  Quiet() { CPLPushErrorHandler(CPLQuietErrorHandler); }
  ~Quiet() { CPLPopErrorHandler(); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
};

Error at_file(const std::string& path, ErrorCode code, std::string message) {
  return Error{code, std::move(message), path};
}

bool ends_with(std::string text, const std::string& end) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

Dataset open_raster(const std::string& name) {
  return Dataset(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
}

// The dataset of a file, or of the first raster inside a .zip.
Dataset open_any(const std::string& path) {
  if (!ends_with(path, ".zip")) return open_raster(path);
  const std::string archive = "/vsizip/" + path;
  char** members = VSIReadDirRecursive(archive.c_str());
  Dataset found;
  for (int i = 0; members != nullptr && members[i] != nullptr && !found; ++i) {
    found = open_raster(archive + "/" + members[i]);
  }
  CSLDestroy(members);
  return found;
}

double unit_m(const std::string& unit) {
  if (unit == "ft" || unit == "foot" || unit == "feet") return kFoot_m;
  if (unit == "US survey foot" || unit == "us-ft" || unit == "ftUS") return kSurveyFoot_m;
  return 1;
}

bool reads_row(GDALDataset& dataset, int band, int row, std::vector<double>& line) {
  const int columns = static_cast<int>(line.size());
  return dataset.GetRasterBand(band)->RasterIO(GF_Read, 0, row, columns, 1, line.data(), columns, 1, GDT_Float64, 0, 0,
                                               nullptr) == CE_None;
}

// Calls put(row from the south, column, height or NaN for a void) for every post. False where reading fails.
template <class Put>
bool each_height(GDALDataset& dataset, HeightEncoding encoding, int columns, int rows, Put&& put) {
  constexpr double kVoid = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> first(static_cast<std::size_t>(columns));
  if (encoding == HeightEncoding::kHeights) {
    GDALRasterBand& band = *dataset.GetRasterBand(1);
    int has_no_data = 0;
    const double no_data = band.GetNoDataValue(&has_no_data);
    const double scale = band.GetScale() * unit_m(band.GetUnitType());
    const double offset = band.GetOffset() * unit_m(band.GetUnitType());
    for (int row = 0; row < rows; ++row) {
      if (!reads_row(dataset, 1, row, first)) return false;
      for (int column = 0; column < columns; ++column) {
        const double raw = first[static_cast<std::size_t>(column)];
        const bool is_void = !std::isfinite(raw) || raw == -32768 || (has_no_data != 0 && raw == no_data);
        put(rows - 1 - row, column, is_void ? kVoid : raw * scale + offset);
      }
    }
    return true;
  }
  std::vector<double> green(first.size()), blue(first.size()), alpha(first.size(), 255);
  const bool has_alpha = dataset.GetRasterCount() >= 4;
  for (int row = 0; row < rows; ++row) {
    if (!reads_row(dataset, 1, row, first) || !reads_row(dataset, 2, row, green) || !reads_row(dataset, 3, row, blue) ||
        (has_alpha && !reads_row(dataset, 4, row, alpha))) {
      return false;
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double code = 65536 * first[i] + 256 * green[i] + blue[i];
      const bool rgb = encoding == HeightEncoding::kTerrainRgb;
      const bool is_void = alpha[i] == 0 || (rgb && code == 0);
      put(rows - 1 - row, static_cast<int>(i), is_void ? kVoid : rgb ? 0.1 * code - 10000 : code / 256 - 32768);
    }
  }
  return true;
}

// Posts that say what no ground on the Earth is.
struct Impossible {
  std::size_t count = 0;
  double height_m = 0;  // of the first
  glm::dvec2 at{0, 0};

  std::string text() const {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "%zu posts have heights that no ground has, such as %.0f m at x %.6f, y %.6f: a number that overflowed, "
        "or another unit?",
        count, height_m, at.x, at.y);
    return text;
  }
};

// Marks what is no height. Rows go north.
bool read_posts(GDALDataset& dataset, HeightEncoding encoding, Grid& grid, std::vector<std::uint8_t>& known,
                Impossible& impossible) {
  grid.values.resize(static_cast<std::size_t>(grid.columns) * grid.rows);
  known.assign(grid.values.size(), 1);
  return each_height(dataset, encoding, grid.columns, grid.rows, [&](int row, int column, double height) {
    const std::size_t i = static_cast<std::size_t>(row) * grid.columns + column;
    known[i] = height >= kLowest_m && height <= kHighest_m;
    if (!known[i] && !std::isnan(height) && impossible.count++ == 0) {
      impossible.height_m = height;
      impossible.at = grid.origin_m + grid.step_m * glm::dvec2(column, row);
    }
    grid.values[i] = known[i] ? static_cast<float>(height) : 0.0f;
  });
}

bool is_colour(GDALDataset& dataset) {
  if (dataset.GetRasterCount() < 3) return false;
  for (int band = 1; band <= 3; ++band) {
    if (dataset.GetRasterBand(band)->GetRasterDataType() != GDT_Byte) return false;
  }
  return true;
}

// The corner (west, north) and the size of a pixel of the tile that .../zoom/x/y.png names, in metres of the web map's
// Mercator projection, as GDAL's geotransform has it.
std::optional<std::array<double, 6>> tile_transform(const std::string& path, int columns, int rows) {
  const std::filesystem::path file(path), column = file.parent_path(), zoom = column.parent_path();
  const auto number = [](const std::string& text) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : -1;
  };
  const int z = number(zoom.filename()), x = number(column.filename()), y = number(file.stem());
  if (z < 0 || z > 30 || x < 0 || y < 0 || x >> z != 0 || y >> z != 0) return std::nullopt;
  constexpr double kHalf_m = 6378137 * std::numbers::pi;
  const double size = 2 * kHalf_m / std::exp2(z);
  return std::array<double, 6>{x * size - kHalf_m, size / columns, 0, kHalf_m - y * size, 0, -size / rows};
}

std::string in_degrees(const Extent& e) {
  char text[160];
  std::snprintf(text, sizeof text, "x %.6f to %.6f, y %.6f to %.6f", e.low.x, e.high.x, e.low.y, e.high.y);
  return text;
}

}  // namespace

struct Elevation::Impl {
  std::string path, vertical_datum;
  std::string vertical = "EPSG:5773";  // the geoid that heights are above, where they are: WKT, or EGM96
  VerticalDatum datum = VerticalDatum::kUnknown;
  Grid grid;
  std::size_t voids = 0;
  std::vector<bool> known;  // of the posts; empty: all
  bool geographic = false;
  double metres_per_unit = 1;
  Transformation from_geographic;  // (longitude, latitude) to the file's coordinates; none where they are the same
  Extent extent;
  mutable std::mutex mutex;  // a transformation of PROJ serves one thread at a time

  glm::dvec2 own(glm::dvec2 place) const {
    if (!from_geographic) return place;
    const std::lock_guard<std::mutex> lock(mutex);
    const Quiet quiet;
    double x = place.x, y = place.y;
    // What cannot be projected is far outside.
    if (!from_geographic->Transform(1, &x, &y)) return {HUGE_VAL, HUGE_VAL};
    return {x, y};
  }

  Extent own_extent() const {
    return {grid.origin_m, grid.origin_m + grid.step_m * glm::dvec2(grid.columns - 1, grid.rows - 1)};
  }

  std::optional<Error> reference(const OGRSpatialReference* found, Diagnostics* diagnostics);
  void find_datum(const OGRSpatialReference* found, const std::string& driver);
  std::optional<Error> convert(const HeightDatum& wanted, Diagnostics* diagnostics);
};

// Finds out what the file's coordinates mean.
std::optional<Error> Elevation::Impl::reference(const OGRSpatialReference* found, Diagnostics* diagnostics) {
  extent = own_extent();
  if (found == nullptr || found->IsLocal()) {
    const Extent& e = extent;
    geographic = e.low.x >= -181 && e.high.x <= 181 && e.low.y >= -91 && e.high.y <= 91 && grid.step_m.x < 0.1;
    if (geographic && diagnostics != nullptr) {
      diagnostics->push_back({Severity::kWarning,
                              "no coordinate system in the file: taken for WGS84 longitude and latitude in degrees (" +
                                  in_degrees(e) + ")",
                              path});
    }
  } else {
    geographic = true;
    OGRSpatialReference native(*found), wgs84;
    native.StripVertical();
    native.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    wgs84.SetWellKnownGeogCS("WGS84");
    wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (!native.IsGeographic()) {
      from_geographic.reset(OGRCreateCoordinateTransformation(&wgs84, &native));
      const Transformation to_geographic(OGRCreateCoordinateTransformation(&native, &wgs84));
      if (!from_geographic || !to_geographic) {
        return at_file(path, ErrorCode::kData, "the coordinate system cannot be related to WGS84");
      }
      metres_per_unit = native.GetLinearUnits();
      const Extent e = own_extent();
      double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
      if (!to_geographic->TransformBounds(e.low.x, e.low.y, e.high.x, e.high.y, &x0, &y0, &x1, &y1, 21)) {
        return at_file(path, ErrorCode::kData, "the extent cannot be expressed in WGS84 degrees");
      }
      extent = {{x0, y0}, {x1, y1}};
      return std::nullopt;
    }
  }
  if (geographic) metres_per_unit = kMetresPerDegree;
  return std::nullopt;
}

// What the file says of its heights.
void Elevation::Impl::find_datum(const OGRSpatialReference* found, const std::string& driver) {
  if (found != nullptr && found->IsCompound()) {
    datum = VerticalDatum::kGeoid;
    if (const char* name = found->GetAttrValue("VERT_CS")) vertical_datum = name;
    char* text = nullptr;
    if (const OGR_SRSNode* node = found->GetAttrNode("VERT_CS"); node && node->exportToWkt(&text) == OGRERR_NONE) {
      vertical = text;
    }
    CPLFree(text);
  } else if (found != nullptr && found->GetAxesCount() == 3) {
    datum = VerticalDatum::kEllipsoid;
  } else if (driver == "SRTMHGT") {
    datum = VerticalDatum::kGeoid;
    vertical_datum = "EGM96 height";
  }
}

// From the datum that the heights are in to that of the roads.
std::optional<Error> Elevation::Impl::convert(const HeightDatum& wanted, Diagnostics* diagnostics) {
  if (wanted.own) datum = *wanted.own == VerticalDatum::kUnknown ? wanted.roads : *wanted.own;
  if (datum == VerticalDatum::kUnknown) datum = wanted.roads;
  if (wanted.roads == VerticalDatum::kUnknown || datum == wanted.roads) return std::nullopt;
  if (!geographic) return at_file(path, ErrorCode::kData, "heights of no place on the Earth have no other datum");
  const Result<Undulation> undulation = Undulation::open(wanted.geoid_path, vertical);
  if (!undulation) {
    Error error = undulation.error();
    error.message = "heights are above the " + std::string(name_of(datum)) + ", those of the roads above the " +
                    name_of(wanted.roads) + ": " + error.message;
    if (error.file.empty()) error.file = path;
    return error;
  }
  const Transformation to_geographic(from_geographic ? from_geographic->GetInverse() : nullptr);
  const double sign = wanted.roads == VerticalDatum::kEllipsoid ? 1 : -1;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      glm::dvec2 at = grid.origin_m + grid.step_m * glm::dvec2(column, row);
      if (to_geographic && !to_geographic->Transform(1, &at.x, &at.y)) continue;
      const std::optional<double> n = undulation->at(at.x, at.y);
      if (!n) {
        char text[120];
        std::snprintf(text, sizeof text, "the geoid's grid does not reach longitude %.6f, latitude %.6f", at.x, at.y);
        return at_file(wanted.geoid_path.empty() ? path : wanted.geoid_path, ErrorCode::kData, text);
      }
      grid.at(column, row) = static_cast<float>(grid.at(column, row) + sign * *n);
      least = std::min(least, *n), most = std::max(most, *n);
    }
  }
  if (diagnostics != nullptr) {
    char text[160];
    std::snprintf(text, sizeof text, "heights above the %s made heights above the %s, which are %.2f to %.2f m %s",
                  name_of(datum), name_of(wanted.roads), least, most, sign > 0 ? "more" : "less");
    diagnostics->push_back({Severity::kInfo, text, path});
  }
  datum = wanted.roads;
  return std::nullopt;
}

Elevation::Elevation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Elevation::~Elevation() = default;
Elevation::Elevation(Elevation&&) noexcept = default;
Elevation& Elevation::operator=(Elevation&&) noexcept = default;

Result<HeightEncoding> height_encoding_from_name(const std::string& name) {
  if (name == "heights") return HeightEncoding::kHeights;
  if (name == "terrain-rgb") return HeightEncoding::kTerrainRgb;
  if (name == "terrarium") return HeightEncoding::kTerrarium;
  return Error{ErrorCode::kUsage,
               "'" + name + "' is no encoding of heights; there are heights, terrain-rgb and terrarium"};
}

Result<Elevation> Elevation::open(const std::string& path, Diagnostics* diagnostics, HeightEncoding encoding,
                                  const HeightDatum& datum) {
  static std::once_flag registered;
  std::call_once(registered, [] { GDALAllRegister(); });
  const Quiet quiet;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return at_file(path, ErrorCode::kIo, "no such elevation file");
  const Dataset dataset = open_any(path);
  if (!dataset || dataset->GetRasterCount() < 1) {
    return at_file(path, ErrorCode::kParse,
                   "not an elevation raster that can be read: " + std::string(CPLGetLastErrorMsg()));
  }
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  Grid& grid = impl->grid;
  grid.columns = dataset->GetRasterXSize();
  grid.rows = dataset->GetRasterYSize();
  if (is_colour(*dataset) != (encoding != HeightEncoding::kHeights)) {
    return at_file(path, ErrorCode::kData,
                   encoding == HeightEncoding::kHeights
                       ? "the raster holds colours; where they stand for heights, say terrain-rgb or terrarium"
                       : "the raster holds no colours that could stand for heights");
  }
  std::array<double, 6> t{};
  OGRSpatialReference web_map;
  const OGRSpatialReference* spatial = dataset->GetSpatialRef();
  if (dataset->GetGeoTransform(t.data()) != CE_None) {
    const auto tile = tile_transform(path, grid.columns, grid.rows);
    if (!tile) return at_file(path, ErrorCode::kData, "the raster does not say where it lies (no geotransform)");
    t = *tile;
    web_map.importFromEPSG(3857);
    spatial = &web_map;
  }
  if (t[2] != 0 || t[4] != 0 || !(t[1] > 0) || !(t[5] < 0)) {
    return at_file(path, ErrorCode::kData, "the raster is rotated or mirrored; warp it to north-up first");
  }
  if (grid.columns < 2 || grid.rows < 2 || std::int64_t{grid.columns} * grid.rows > kMostPosts) {
    return at_file(path, ErrorCode::kData,
                   "the raster has " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows) +
                       " posts; 2 x 2 to 2^28 posts are handled");
  }
  // GDAL's geotransform is of pixel corners, heights are of pixel centres.
  grid.step_m = {t[1], -t[5]};
  grid.origin_m = {t[0] + 0.5 * t[1], t[3] + (grid.rows - 0.5) * t[5]};
  if (auto error = impl->reference(spatial, diagnostics)) return *error;
  impl->find_datum(spatial, dataset->GetDriver()->GetDescription());

  std::vector<std::uint8_t> known;
  Impossible impossible;
  if (!read_posts(*dataset, encoding, grid, known, impossible)) {
    return at_file(path, ErrorCode::kIo, "reading the heights failed: " + std::string(CPLGetLastErrorMsg()));
  }
  if (impossible.count == known.size()) return at_file(path, ErrorCode::kData, impossible.text());
  if (impossible.count > 0 && diagnostics != nullptr) {
    diagnostics->push_back({Severity::kWarning, impossible.text() + " They count as voids", path});
  }
  if (std::count(known.begin(), known.end(), std::uint8_t{1}) == 0) {
    return at_file(path, ErrorCode::kData, "the raster holds no heights, only voids");
  }
  impl->voids = fill_holes(grid, known);
  if (impl->voids > 0) impl->known.assign(known.begin(), known.end());
  if (impl->voids > 0 && diagnostics != nullptr) {
    diagnostics->push_back(
        {Severity::kInfo, std::to_string(impl->voids) + " voids filled from their surroundings", path});
  }
  if (auto error = impl->convert(datum, diagnostics)) return *error;
  return Elevation(std::move(impl));
}

bool Elevation::is_geographic() const { return impl_->geographic; }

double Elevation::height_m(glm::dvec2 place, Interpolation interpolation) const {
  const glm::dvec2 own = impl_->own(place);
  return interpolation == Interpolation::kBilinear ? sample_bilinear(impl_->grid, own)
                                                   : sample_bicubic(impl_->grid, own);
}

bool Elevation::covers(glm::dvec2 place) const {
  // A post's width of rounding would be too much to forgive, a thousandth is not.
  const glm::dvec2 slack = 1e-3 * impl_->grid.step_m;
  Extent e = impl_->own_extent();
  e.low -= slack;
  e.high += slack;
  return e.contains(impl_->own(place));
}

bool Elevation::is_measured(glm::dvec2 place) const {
  if (!covers(place)) return false;
  if (impl_->known.empty()) return true;
  const Grid& grid = impl_->grid;
  const glm::dvec2 at = (impl_->own(place) - grid.origin_m) / grid.step_m;
  const int column = std::clamp(static_cast<int>(at.x), 0, grid.columns - 2);
  const int row = std::clamp(static_cast<int>(at.y), 0, grid.rows - 2);
  const auto is_known = [&](int x, int y) { return impl_->known[static_cast<std::size_t>(y) * grid.columns + x]; };
  return is_known(column, row) && is_known(column + 1, row) && is_known(column, row + 1) &&
         is_known(column + 1, row + 1);
}

Extent Elevation::extent() const { return impl_->extent; }

double Elevation::post_spacing_m() const {
  double x = impl_->grid.step_m.x * impl_->metres_per_unit;
  const double y = impl_->grid.step_m.y * impl_->metres_per_unit;
  if (impl_->geographic && !impl_->from_geographic) {
    const double middle = 0.5 * (impl_->extent.low.y + impl_->extent.high.y) * std::numbers::pi / 180;
    x *= std::max(std::cos(middle), 0.01);
  }
  return std::min(x, y);
}

const std::string& Elevation::vertical_datum() const { return impl_->vertical_datum; }
VerticalDatum Elevation::datum() const { return impl_->datum; }
const std::string& Elevation::path() const { return impl_->path; }
std::size_t Elevation::voids_filled() const { return impl_->voids; }
const Grid& Elevation::posts() const { return impl_->grid; }

namespace {

// WGS84 with what heights are measured from.
OGRSpatialReference system_of(VerticalDatum datum, const std::string& geoid) {
  OGRSpatialReference system;
  system.SetWellKnownGeogCS("WGS84");
  if (datum == VerticalDatum::kEllipsoid) system.importFromEPSG(4979);
  if (datum == VerticalDatum::kGeoid) {
    OGRSpatialReference flat = system, height;
    if (geoid.empty() || geoid == "EGM96 height") {
      height.importFromEPSG(5773);
    } else if (geoid == "EGM2008 height") {
      height.importFromEPSG(3855);
    } else {
      height.SetVertCS(geoid.c_str(), geoid.c_str());
    }
    system.SetCompoundCS(("WGS 84 + " + std::string(height.GetName())).c_str(), &flat, &height);
  }
  system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return system;
}

}  // namespace

Status write_geotiff(const Grid& heights, const std::string& path, VerticalDatum datum, const std::string& geoid) {
  GDALAllRegister();
  const Quiet quiet;
  const std::string part = path + ".part";
  const auto fail = [&](const std::string& what) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return at_file(path, ErrorCode::kIo, what + ": " + CPLGetLastErrorMsg());
  };
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr) return fail("GDAL has no GeoTIFF driver");
  char** options = CSLSetNameValue(nullptr, "COMPRESS", "DEFLATE");
  options = CSLSetNameValue(options, "PREDICTOR", "3");
  Dataset dataset(driver->Create(part.c_str(), heights.columns, heights.rows, 1, GDT_Float32, options));
  CSLDestroy(options);
  if (!dataset) return fail("the file cannot be written");
  const glm::dvec2 step = heights.step_m;
  double t[6] = {
      heights.origin_m.x - 0.5 * step.x, step.x, 0, heights.origin_m.y + (heights.rows - 0.5) * step.y, 0, -step.y};
  const OGRSpatialReference system = system_of(datum, geoid);
  bool good = dataset->SetGeoTransform(t) == CE_None && dataset->SetSpatialRef(&system) == CE_None;
  GDALRasterBand* band = dataset->GetRasterBand(1);
  band->SetUnitType("m");
  for (int row = 0; row < heights.rows && good; ++row) {
    const float* from = &heights.values[static_cast<std::size_t>(heights.rows - 1 - row) * heights.columns];
    auto* line = const_cast<float*>(from);  // GDAL only reads it
    good = band->RasterIO(GF_Write, 0, row, heights.columns, 1, line, heights.columns, 1, GDT_Float32, 0, 0, nullptr) ==
           CE_None;
  }
  CPLErrorReset();
  dataset.reset();  // flushes; a full disk shows here
  good = good && CPLGetLastErrorType() < CE_Failure;
  if (!good) return fail("writing the heights failed");
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) return fail("the file cannot be put in place");
  return Done{};
}

}  // namespace roadgen
