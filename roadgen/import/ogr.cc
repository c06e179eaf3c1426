#include "roadgen/import/ogr.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

// Collects GDAL's messages of this thread instead of letting them go to stderr, for as long as it lives.
class GdalMessages {
 public:
  GdalMessages() { CPLPushErrorHandlerEx(&GdalMessages::take, this); }
  ~GdalMessages() { CPLPopErrorHandler(); }
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  std::string failure;  // the first one, or empty
  std::vector<std::string> warnings;

 private:
  static void CPL_STDCALL take(CPLErr severity, CPLErrorNum, const char* message) {
    auto* self = static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
    std::string text = message;
    for (char& c : text) {
      if (c == '\n' || c == '\r') c = ' ';
    }
    if (severity >= CE_Failure && self->failure.empty()) self->failure = text;
    if (severity == CE_Warning) self->warnings.push_back(text);
  }
};

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

struct DestroyTransformation {
  void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using Transformation = std::unique_ptr<OGRCoordinateTransformation, DestroyTransformation>;

struct DestroyFeature {
  void operator()(OGRFeature* feature) const { OGRFeature::DestroyFeature(feature); }
};

class Reader {
 public:
  Reader(const std::string& path, Diagnostics& diagnostics) : path_(path), diagnostics_(diagnostics) {}

  Result<std::vector<Track>> read();

 private:
  Status read_layer(OGRLayer& layer);
  Status read_feature(const OGRFeature& feature, OGRCoordinateTransformation* to_wgs84, bool geodetic);
  Status read_line(const OGRLineString& line, const Track& like, OGRCoordinateTransformation* to_wgs84);

  const std::string& path_;
  Diagnostics& diagnostics_;
  GdalMessages messages_;
  std::vector<Track> tracks_;
  int not_lines_ = 0;
};

std::string property(const OGRFeature& feature, const char* name) {
  const int field = feature.GetFieldIndex(name);  // ignores case
  return field >= 0 && feature.IsFieldSetAndNotNull(field) ? feature.GetFieldAsString(field) : "";
}

Status Reader::read_line(const OGRLineString& line, const Track& like, OGRCoordinateTransformation* to_wgs84) {
  Track track = like;
  const bool has_height = line.Is3D();
  int left_out = 0;
  for (int i = 0; i < line.getNumPoints(); ++i) {
    TrackPoint point{line.getX(i), line.getY(i)};
    if (has_height && std::isfinite(line.getZ(i))) point.height_m = line.getZ(i);
    if (std::isfinite(point.x) && std::isfinite(point.y) && to_wgs84 && !to_wgs84->Transform(1, &point.x, &point.y)) {
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

Status Reader::read_feature(const OGRFeature& feature, OGRCoordinateTransformation* to_wgs84, bool geodetic) {
  const OGRGeometry* geometry = feature.GetGeometryRef();
  if (!geometry || geometry->IsEmpty()) return Done{};
  Track track{path_, property(feature, "id"), property(feature, "name"), geodetic};
  if (track.element.empty()) track.element = track.name;
  if (track.element.empty()) track.element = "feature " + std::to_string(feature.GetFID());
  if (track.name.empty()) track.name = track.element;

  const std::unique_ptr<OGRGeometry> linear(geometry->getLinearGeometry());
  const OGRwkbGeometryType type = wkbFlatten(linear->getGeometryType());
  if (type == wkbLineString) return read_line(*linear->toLineString(), track, to_wgs84);
  if (type != wkbMultiLineString) {
    ++not_lines_;
    return Done{};
  }
  const Track whole = track;
  int part = 0;
  for (const OGRLineString* line : *linear->toMultiLineString()) {
    const std::string suffix = " part " + std::to_string(++part);
    track.element = whole.element + suffix;
    track.name = whole.name + suffix;
    if (Status status = read_line(*line, track, to_wgs84); !status) return status;
  }
  return Done{};
}

Status Reader::read_layer(OGRLayer& layer) {
  OGRSpatialReference wgs84;
  wgs84.SetWellKnownGeogCS("WGS84");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  Transformation to_wgs84;
  const OGRSpatialReference* system = layer.GetSpatialRef();
  if (!system) {
    diagnostics_.push_back({Severity::kWarning, "no coordinate system: coordinates are taken as metres east and north",
                            path_, 0, layer.GetName()});
  } else {
    OGRSpatialReference source(*system);
    source.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (!source.IsSame(&wgs84)) {
      to_wgs84.reset(OGRCreateCoordinateTransformation(&source, &wgs84));
      if (!to_wgs84) {
        return Error{ErrorCode::kData, "its coordinate system cannot be changed to WGS84: " + messages_.failure, path_};
      }
    }
  }
  layer.ResetReading();
  while (const std::unique_ptr<OGRFeature, DestroyFeature> feature{layer.GetNextFeature()}) {
    if (Status status = read_feature(*feature, to_wgs84.get(), system != nullptr); !status) return status;
  }
  return Done{};
}

Result<std::vector<Track>> Reader::read() {
  static std::once_flag registered;
  std::call_once(registered, GDALAllRegister);
  const char* const drivers[] = {"GeoJSON", "LIBKML", "KML", "ESRI Shapefile", "GPKG", nullptr};
  const Dataset dataset(static_cast<GDALDataset*>(
      GDALOpenEx(path_.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, nullptr, nullptr)));
  const auto unreadable = [&] {
    const std::string why = messages_.failure.empty() ? "it is not of the kind that its name says" : messages_.failure;
    return Error{ErrorCode::kParse, "cannot be read (truncated?): " + why, path_};
  };
  if (!dataset) return unreadable();

  for (int i = 0; i < dataset->GetLayerCount(); ++i) {
    if (Status status = read_layer(*dataset->GetLayer(i)); !status) return status.error();
    if (!messages_.failure.empty()) return unreadable();
  }
  for (const std::string& warning : messages_.warnings) diagnostics_.push_back({Severity::kWarning, warning, path_});
  if (not_lines_ > 0) {
    diagnostics_.push_back(
        {Severity::kWarning, std::to_string(not_lines_) + " features that are not lines left out", path_});
  }
  if (tracks_.empty())
    return Error{ErrorCode::kData, "holds no line; a road is a LineString or MultiLineString", path_};
  return std::move(tracks_);
}

}  // namespace

Result<std::vector<Track>> read_vector(const std::string& path, Diagnostics& diagnostics) {
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return bytes.error();
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending != ".shp" && ending != ".gpkg") {
    if (Status status = check_utf8(*bytes, path); !status) return status.error();
  }
  return Reader(path, diagnostics).read();
}

}  // namespace roadgen
