#include "terrain/vertical_datum.h"

#include <filesystem>

#include <cpl_error.h>
#include <ogr_spatialref.h>

#include "roadgen/geodesy/geoid_file.h"
#include "terrain/elevation.h"

namespace roadgen {
namespace {

struct CloseTransformation {
  void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};

}  // namespace

const char* name_of(VerticalDatum datum) {
  return datum == VerticalDatum::kGeoid ? "geoid" : datum == VerticalDatum::kEllipsoid ? "ellipsoid" : "unknown";
}

Result<std::optional<VerticalDatum>> elevation_datum_from_name(const std::string& name) {
  using Datum = std::optional<VerticalDatum>;
  if (name == "file") return Datum();
  if (name == "geoid") return Datum(VerticalDatum::kGeoid);
  if (name == "ellipsoid") return Datum(VerticalDatum::kEllipsoid);
  if (name == "as-roads") return Datum(VerticalDatum::kUnknown);
  return Error{ErrorCode::kUsage, "--dem-datum '" + name + "': expected file, geoid, ellipsoid or as-roads"};
}

Result<VerticalDatum> road_datum_from_name(const std::string& name, const Network& network) {
  if (name == "geoid") return VerticalDatum::kGeoid;
  if (name == "ellipsoid") return VerticalDatum::kEllipsoid;
  if (name != "file") {
    return Error{ErrorCode::kUsage, "--road-datum '" + name + "': expected file, geoid or ellipsoid"};
  }
  if (!network.georeference || network.georeference->projection.empty()) return VerticalDatum::kUnknown;
  CPLPushErrorHandler(CPLQuietErrorHandler);
  OGRSpatialReference found;
  const bool read = found.SetFromUserInput(network.georeference->projection.c_str()) == OGRERR_NONE;
  CPLPopErrorHandler();
  if (read && found.IsCompound()) return VerticalDatum::kGeoid;
  return read && found.GetAxesCount() == 3 ? VerticalDatum::kEllipsoid : VerticalDatum::kUnknown;
}

struct Undulation::Impl {
  std::optional<Elevation> raster;
  std::optional<GeoidFile> geoid;
  std::unique_ptr<OGRCoordinateTransformation, CloseTransformation> to_ellipsoid;
};

Undulation::Undulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Undulation::~Undulation() = default;
Undulation::Undulation(Undulation&&) noexcept = default;
Undulation& Undulation::operator=(Undulation&&) noexcept = default;

Result<Undulation> Undulation::open(const std::string& geoid_path, const std::string& vertical) {
  auto impl = std::make_unique<Impl>();
  if (std::filesystem::path(geoid_path).extension() == ".pgm") {
    auto geoid = GeoidFile::open(geoid_path);
    if (!geoid) return geoid.error();
    impl->geoid.emplace(std::move(*geoid));
  } else if (!geoid_path.empty()) {
    auto raster = Elevation::open(geoid_path);
    if (!raster) return raster.error();
    // Longitude and latitude, also where the file does not say so.
    const Extent e = raster->extent();
    if (e.low.x < -361 || e.high.x > 361 || e.low.y < -91 || e.high.y > 91) {
      return Error{ErrorCode::kData, "the geoid does not lie on longitude and latitude", geoid_path};
    }
    impl->raster.emplace(std::move(*raster));
  } else {
    CPLPushErrorHandler(CPLQuietErrorHandler);
    OGRSpatialReference flat, height, both, ellipsoid;
    flat.SetWellKnownGeogCS("WGS84");
    bool good = height.SetFromUserInput(vertical.c_str()) == OGRERR_NONE;
    good = good && both.SetCompoundCS("geoid", &flat, &height) == OGRERR_NONE;
    good = good && ellipsoid.importFromEPSG(4979) == OGRERR_NONE;
    both.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    ellipsoid.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformationOptions options;
    options.SetBallparkAllowed(false);  // or it would leave heights as they are where the grid is missing
    if (good) impl->to_ellipsoid.reset(OGRCreateCoordinateTransformation(&both, &ellipsoid, options));
    CPLPopErrorHandler();
    const std::string name = good ? height.GetName() : vertical;
    Undulation made(std::move(impl));
    if (made.impl_->to_ellipsoid && made.at(0, 0)) return made;
    return Error{ErrorCode::kData,
                 "PROJ has no grid of the geoid '" + name + "'; install it, or name one by --geoid FILE"};
  }
  return Undulation(std::move(impl));
}

std::optional<double> Undulation::at(double longitude_deg, double latitude_deg) const {
  if (impl_->geoid) return impl_->geoid->undulation_m(longitude_deg, latitude_deg);
  if (impl_->raster) {
    for (const double turn : {0.0, 360.0, -360.0}) {
      const glm::dvec2 place(longitude_deg + turn, latitude_deg);
      if (impl_->raster->covers(place)) return impl_->raster->height_m(place, Interpolation::kBilinear);
    }
    return std::nullopt;
  }
  CPLPushErrorHandler(CPLQuietErrorHandler);
  double x = longitude_deg, y = latitude_deg, z = 0;
  const bool good = impl_->to_ellipsoid->Transform(1, &x, &y, &z) != 0;
  CPLPopErrorHandler();
  return good ? std::optional(z) : std::nullopt;
}

}  // namespace roadgen
