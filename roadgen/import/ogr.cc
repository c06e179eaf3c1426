#include "roadgen/import/ogr.h"

#include <cpl_error.h>
#include <dlfcn.h>
#include <gdal.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

// What is called of GDAL. The library is loaded when a file first needs it: with the 100 others that it needs it takes
// 30 MB and 60 ms, more than the import of a town.
#define ROADGEN_GDAL_FUNCTIONS(X)       \
  X(CPLGetErrorHandlerUserData)         \
  X(CPLPopErrorHandler)                 \
  X(CPLPushErrorHandlerEx)              \
  X(GDALAllRegister)                    \
  X(GDALClose)                          \
  X(GDALDatasetGetLayer)                \
  X(GDALDatasetGetLayerCount)           \
  X(GDALOpenEx)                         \
  X(OCTDestroyCoordinateTransformation) \
  X(OCTNewCoordinateTransformation)     \
  X(OCTTransform)                       \
  X(OGR_F_Destroy)                      \
  X(OGR_F_GetFID)                       \
  X(OGR_F_GetFieldAsString)             \
  X(OGR_F_GetFieldIndex)                \
  X(OGR_F_GetGeometryRef)               \
  X(OGR_F_IsFieldSetAndNotNull)         \
  X(OGR_GT_Flatten)                     \
  X(OGR_G_DestroyGeometry)              \
  X(OGR_G_GetGeometryCount)             \
  X(OGR_G_GetGeometryRef)               \
  X(OGR_G_GetGeometryType)              \
  X(OGR_G_GetLinearGeometry)            \
  X(OGR_G_GetPointCount)                \
  X(OGR_G_GetX)                         \
  X(OGR_G_GetY)                         \
  X(OGR_G_GetZ)                         \
  X(OGR_G_Is3D)                         \
  X(OGR_G_IsEmpty)                      \
  X(OGR_L_GetName)                      \
  X(OGR_L_GetNextFeature)               \
  X(OGR_L_GetSpatialRef)                \
  X(OGR_L_ResetReading)                 \
  X(OSRClone)                           \
  X(OSRDestroySpatialReference)         \
  X(OSRIsSame)                          \
  X(OSRNewSpatialReference)             \
  X(OSRSetAxisMappingStrategy)          \
  X(OSRSetWellKnownGeogCS)

struct Gdal {
#define ROADGEN_MEMBER(name) decltype(&::name) name = nullptr;
  ROADGEN_GDAL_FUNCTIONS(ROADGEN_MEMBER)
#undef ROADGEN_MEMBER
  std::string failure;  // why it is not there; empty where it is
};

Gdal load_gdal() {
  Gdal gdal;
  void* library = ::dlopen(ROADGEN_GDAL_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  const auto fail = [&] {
    const char* why = ::dlerror();
    gdal.failure = why ? why : ROADGEN_GDAL_LIBRARY " lacks a function";
  };
  if (!library) {
    fail();
    return gdal;
  }
#define ROADGEN_LOAD(name)                                                  \
  gdal.name = reinterpret_cast<decltype(&::name)>(::dlsym(library, #name)); \
  if (!gdal.name && gdal.failure.empty()) fail();
  ROADGEN_GDAL_FUNCTIONS(ROADGEN_LOAD)
#undef ROADGEN_LOAD
  if (gdal.failure.empty()) gdal.GDALAllRegister();
  return gdal;
}

// It stays loaded.
const Gdal& gdal() {
  static const Gdal loaded = load_gdal();
  return loaded;
}

// Collects GDAL's messages of this thread instead of letting them go to stderr, for as long as it lives.
class GdalMessages {
 public:
  GdalMessages() { gdal().CPLPushErrorHandlerEx(&GdalMessages::take, this); }
  ~GdalMessages() { gdal().CPLPopErrorHandler(); }
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  std::string failure;  // the first one, or empty
  std::vector<std::string> warnings;

 private:
  static void CPL_STDCALL take(CPLErr severity, CPLErrorNum, const char* message) {
    auto* self = static_cast<GdalMessages*>(gdal().CPLGetErrorHandlerUserData());
    std::string text = message;
    for (char& c : text) {
      if (c == '\n' || c == '\r') c = ' ';
    }
    if (severity >= CE_Failure && self->failure.empty()) self->failure = text;
    if (severity == CE_Warning) self->warnings.push_back(text);
  }
};

// What a function of GDAL made, until another of them frees it.
template <class Handle>
class Owned {
 public:
  using Free = void (*)(Handle);
  Owned(Handle handle, Free free) : handle_(handle), free_(free) {}
  ~Owned() {
    if (handle_) free_(handle_);
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  Handle get() const { return handle_; }
  explicit operator bool() const { return handle_ != nullptr; }

 private:
  Handle handle_;
  Free free_;
};

// What a feature's properties say of all its points.
struct Given {
  std::optional<double> height_m, width_m;
};

class Reader {
 public:
  Reader(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics)
      : path_(path), fields_(fields), diagnostics_(diagnostics) {}

  Result<std::vector<Track>> read();

 private:
  Status read_layer(OGRLayerH layer);
  Status read_feature(OGRFeatureH feature, OGRCoordinateTransformationH to_wgs84, bool geodetic);
  Status read_line(OGRGeometryH line, const Track& like, const Given& given, OGRCoordinateTransformationH to_wgs84);

  // Of a property that the caller names.
  std::optional<double> number(OGRFeatureH feature, const std::string& name, const Track& of);

  const std::string& path_;
  const FieldNames& fields_;
  Diagnostics& diagnostics_;
  std::set<std::string> met_;  // of the names in fields_
  GdalMessages messages_;
  std::vector<Track> tracks_;
  int not_lines_ = 0;
};

std::string property(OGRFeatureH feature, const char* name) {
  const int field = gdal().OGR_F_GetFieldIndex(feature, name);  // ignores case
  const bool known = field >= 0 && gdal().OGR_F_IsFieldSetAndNotNull(feature, field);
  return known ? gdal().OGR_F_GetFieldAsString(feature, field) : "";
}

std::optional<double> Reader::number(OGRFeatureH feature, const std::string& name, const Track& of) {
  if (name.empty() || gdal().OGR_F_GetFieldIndex(feature, name.c_str()) < 0) return {};
  met_.insert(name);
  const std::string text = property(feature, name.c_str());
  if (text.empty()) return {};
  const std::optional<double> value = parse_number(text);
  if (value && std::isfinite(*value)) return value;
  diagnostics_.push_back(
      {Severity::kWarning, "the property " + name + " is not a number: the default is used", path_, 0, of.element});
  return {};
}

Status Reader::read_line(OGRGeometryH line, const Track& like, const Given& given,
                         OGRCoordinateTransformationH to_wgs84) {
  Track track = like;
  const bool has_height = gdal().OGR_G_Is3D(line);
  int left_out = 0;
  for (int i = 0; i < gdal().OGR_G_GetPointCount(line); ++i) {
    TrackPoint point{gdal().OGR_G_GetX(line, i), gdal().OGR_G_GetY(line, i)};
    const double height = has_height ? gdal().OGR_G_GetZ(line, i) : NAN;
    point.height_m = given.height_m;
    if (std::isfinite(height)) point.height_m = height;
    point.width_m = given.width_m;
    if (std::isfinite(point.x) && std::isfinite(point.y) && to_wgs84 &&
        !gdal().OCTTransform(to_wgs84, 1, &point.x, &point.y, nullptr)) {
      return Error{ErrorCode::kData, "point " + std::to_string(i + 1) + " cannot be changed to latitude and longitude",
                   path_, 0, track.element};
    }
    point.index = i + 1;
    if (std::isfinite(point.x) && std::isfinite(point.y))
      track.points.push_back(point);
    else
      ++left_out;
  }
  if (left_out > 0) {
    diagnostics_.push_back({Severity::kWarning, "position not finite: " + std::to_string(left_out) + " points left out",
                            path_, 0, track.element});
  }
  tracks_.push_back(std::move(track));
  return Done{};
}

Status Reader::read_feature(OGRFeatureH feature, OGRCoordinateTransformationH to_wgs84, bool geodetic) {
  const OGRGeometryH geometry = gdal().OGR_F_GetGeometryRef(feature);
  if (!geometry || gdal().OGR_G_IsEmpty(geometry)) return Done{};
  const std::string name_field = fields_.name.empty() ? "name" : fields_.name;
  if (gdal().OGR_F_GetFieldIndex(feature, name_field.c_str()) >= 0) met_.insert(name_field);
  Track track{path_, property(feature, "id"), property(feature, name_field.c_str()), geodetic};
  if (track.element.empty()) track.element = track.name;
  if (track.element.empty()) track.element = "feature " + std::to_string(gdal().OGR_F_GetFID(feature));
  if (track.name.empty()) track.name = track.element;
  const Given given{number(feature, fields_.height, track), number(feature, fields_.width, track)};
  if (const auto lanes = number(feature, fields_.lanes, track)) {
    track.lanes = lane_count(*lanes, path_, 0, track.element, diagnostics_);
  }

  const Owned<OGRGeometryH> linear(gdal().OGR_G_GetLinearGeometry(geometry, 0, nullptr), gdal().OGR_G_DestroyGeometry);
  const OGRwkbGeometryType type = gdal().OGR_GT_Flatten(gdal().OGR_G_GetGeometryType(linear.get()));
  if (type == wkbLineString) return read_line(linear.get(), track, given, to_wgs84);
  if (type != wkbMultiLineString) {
    ++not_lines_;
    return Done{};
  }
  const Track whole = track;
  for (int i = 0; i < gdal().OGR_G_GetGeometryCount(linear.get()); ++i) {
    const std::string suffix = " part " + std::to_string(i + 1);
    track.element = whole.element + suffix;
    track.name = whole.name + suffix;
    const OGRGeometryH line = gdal().OGR_G_GetGeometryRef(linear.get(), i);
    if (Status status = read_line(line, track, given, to_wgs84); !status) return status;
  }
  return Done{};
}

Status Reader::read_layer(OGRLayerH layer) {
  using System = Owned<OGRSpatialReferenceH>;
  const System wgs84(gdal().OSRNewSpatialReference(nullptr), gdal().OSRDestroySpatialReference);
  gdal().OSRSetWellKnownGeogCS(wgs84.get(), "WGS84");
  gdal().OSRSetAxisMappingStrategy(wgs84.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const OGRSpatialReferenceH system = gdal().OGR_L_GetSpatialRef(layer);
  const System source(system ? gdal().OSRClone(system) : nullptr, gdal().OSRDestroySpatialReference);
  bool to_be_changed = false;
  if (!source) {
    diagnostics_.push_back({Severity::kWarning, "no coordinate system: coordinates are taken as metres east and north",
                            path_, 0, gdal().OGR_L_GetName(layer)});
  } else {
    gdal().OSRSetAxisMappingStrategy(source.get(), OAMS_TRADITIONAL_GIS_ORDER);
    to_be_changed = !gdal().OSRIsSame(source.get(), wgs84.get());
  }
  const Owned<OGRCoordinateTransformationH> to_wgs84(
      to_be_changed ? gdal().OCTNewCoordinateTransformation(source.get(), wgs84.get()) : nullptr,
      gdal().OCTDestroyCoordinateTransformation);
  if (to_be_changed && !to_wgs84) {
    return Error{ErrorCode::kData, "its coordinate system cannot be changed to WGS84: " + messages_.failure, path_};
  }
  gdal().OGR_L_ResetReading(layer);
  for (;;) {
    const Owned<OGRFeatureH> feature(gdal().OGR_L_GetNextFeature(layer), gdal().OGR_F_Destroy);
    if (!feature) return Done{};
    if (Status status = read_feature(feature.get(), to_wgs84.get(), bool{source}); !status) return status;
  }
}

Result<std::vector<Track>> Reader::read() {
  const char* const drivers[] = {"GeoJSON", "LIBKML", "KML", "ESRI Shapefile", "GPKG", nullptr};
  const auto close = [](GDALDatasetH dataset) { (void)gdal().GDALClose(dataset); };
  const Owned<GDALDatasetH> dataset(
      gdal().GDALOpenEx(path_.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, nullptr, nullptr), close);
  const auto unreadable = [&] {
    const std::string why = messages_.failure.empty() ? "it is not of the kind that its name says" : messages_.failure;
    return Error{ErrorCode::kParse, "cannot be read (truncated?): " + why, path_};
  };
  if (!dataset) return unreadable();

  for (int i = 0; i < gdal().GDALDatasetGetLayerCount(dataset.get()); ++i) {
    if (Status status = read_layer(gdal().GDALDatasetGetLayer(dataset.get(), i)); !status) return status.error();
    if (!messages_.failure.empty()) return unreadable();
  }
  for (const std::string& warning : messages_.warnings) diagnostics_.push_back({Severity::kWarning, warning, path_});
  if (not_lines_ > 0) {
    diagnostics_.push_back(
        {Severity::kWarning, std::to_string(not_lines_) + " features that are not lines left out", path_});
  }
  for (const std::string* field : {&fields_.width, &fields_.lanes, &fields_.height, &fields_.name}) {
    if (!field->empty() && !met_.contains(*field)) {
      return Error{ErrorCode::kData, "has no property '" + *field + "'", path_};
    }
  }
  if (tracks_.empty())
    return Error{ErrorCode::kData, "holds no line; a road is a LineString or MultiLineString", path_};
  return std::move(tracks_);
}

}  // namespace

Result<std::vector<Track>> read_vector(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics) {
  if (Status status = check_is_file(path); !status) return status.error();
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending != ".shp" && ending != ".gpkg") {
    const Result<std::string> bytes = read_file(path);
    if (!bytes) return bytes.error();
    if (Status status = check_utf8(*bytes, path); !status) return status.error();
  }
  if (!gdal().failure.empty()) {
    return Error{ErrorCode::kIo, "cannot be read without the library GDAL: " + gdal().failure, path};
  }
  return Reader(path, fields, diagnostics).read();
}

}  // namespace roadgen
