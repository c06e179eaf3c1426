#include "roadgen/import/import.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/osm_file.h"
#include "roadgen/import/osm_network.h"

namespace roadgen {
namespace {

constexpr double kFarFromOrigin_m = 50e3;

Status check_options(const std::vector<std::string>& paths, const ImportOptions& options) {
  const auto usage = [](const std::string& message) { return Error{ErrorCode::kUsage, message}; };
  if (paths.empty()) return usage("no file to import");
  for (const double allowed_m :
       {options.max_error_m.value_or(kMapError_m), options.max_height_error_m.value_or(kMapError_m)}) {
    if (!(allowed_m >= kLeastMaxError_m && allowed_m <= kGreatestMaxError_m)) {
      return usage("the greatest error must be between 0.001 and 100 m");
    }
  }
  if (!(options.width_m >= kLeastWidth_m && options.width_m <= kGreatestWidth_m)) {
    return usage("the width must be between 0.5 and 200 m");
  }
  if (options.origin) {
    const Georeference& o = *options.origin;
    if (!(std::abs(o.latitude_deg) <= 90) || !(std::abs(o.longitude_deg) <= 180) || !std::isfinite(o.height_m)) {
      return usage("the origin must be a latitude within 90 and a longitude within 180 degrees");
    }
  }
  return Done{};
}

Result<std::vector<Track>> read_all(const std::vector<std::string>& paths, const FieldNames& fields,
                                    const Progress& progress, Diagnostics& diagnostics) {
  std::vector<Track> tracks;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (progress) progress(0.1 * static_cast<double>(i) / static_cast<double>(paths.size()), "reading " + paths[i]);
    Result<std::vector<Track>> read = read_tracks(paths[i], fields, diagnostics);
    if (!read) return read.error();
    for (Track& track : *read) {
      if (Status status = check_range(track); !status) return status.error();
      if (!tracks.empty() && tracks.front().geodetic != track.geodetic) {
        return Error{ErrorCode::kData,
                     "holds " + std::string(track.geodetic ? "degrees" : "metres") +
                         " where a file before holds the other: import them one at a time",
                     track.file};
      }
      tracks.push_back(std::move(track));
    }
  }
  return tracks;
}

// Centre of the box around all points. Where the box would be wider than half the globe it crosses the
// antimeridian.
Georeference centre_of(const std::vector<Track>& tracks) {
  double south = 90, north = -90, west = 180, east = -180, west_of_0 = -180, east_of_0 = 180;
  for (const Track& track : tracks) {
    for (const TrackPoint& p : track.points) {
      south = std::min(south, p.y), north = std::max(north, p.y);
      west = std::min(west, p.x), east = std::max(east, p.x);
      (p.x < 0 ? west_of_0 : east_of_0) = p.x < 0 ? std::max(west_of_0, p.x) : std::min(east_of_0, p.x);
    }
  }
  if (east - west > 180) {
    west = east_of_0;
    east = west_of_0 + 360;
  }
  const auto rounded = [](double degrees) { return std::round(degrees * 1e6) / 1e6; };
  return {rounded((south + north) / 2), rounded(std::remainder((west + east) / 2, 360)), 0};
}

// On the plane of the origin, at height 0: what cleaning measures distances in.
std::vector<glm::dvec2> flat_positions(const Track& track, const LocalFrame* frame) {
  std::vector<glm::dvec2> positions;
  positions.reserve(track.points.size());
  for (const TrackPoint& p : track.points) {
    positions.push_back(frame ? glm::dvec2(frame->to_local_m({p.y, p.x, 0})) : glm::dvec2(p.x, p.y));
  }
  return positions;
}

std::vector<Sample> samples_of(const CleanTrack& track, const LocalFrame* frame, double& greatest_distance_m) {
  std::vector<Sample> samples;
  samples.reserve(track.points.size());
  for (const CleanPoint& p : track.points) {
    const glm::dvec3 local =
        frame ? frame->to_local_m({p.source.y, p.source.x, p.height_m}) : glm::dvec3(p.position_m, p.height_m);
    samples.push_back({glm::dvec2(local), local.z, p.width_m / 2});
    if (frame) greatest_distance_m = std::max(greatest_distance_m, glm::length(glm::dvec2(local)));
  }
  return samples;
}

struct Job {
  CleanTrack track;
  std::string file;
  bool recorded;
  std::optional<int> lanes;
};

Result<std::vector<Job>> clean_all(const std::vector<Track>& tracks, const LocalFrame* frame,
                                   const ImportOptions& options, Diagnostics& diagnostics) {
  std::vector<Job> jobs;
  std::optional<Error> too_short;
  for (const Track& track : tracks) {
    const double width_m = 0.5 * track.lanes.value_or(2) * options.width_m;
    Result<std::vector<CleanTrack>> cleaned =
        clean_track(track, flat_positions(track, frame), {options.closed, width_m}, diagnostics);
    if (!cleaned) {
      const Error& e = cleaned.error();
      diagnostics.push_back({Severity::kWarning, e.message + ": left out", e.file, e.line, e.element});
      if (!too_short) too_short = e;
      continue;
    }
    for (CleanTrack& piece : *cleaned) jobs.push_back({std::move(piece), track.file, track.recorded, track.lanes});
  }
  if (jobs.empty()) return *too_short;
  return jobs;
}

Status fit_into(ImportResult& result, const Job& job, const LocalFrame* frame, const ImportOptions& options) {
  FitOptions fit;
  fit.max_error_m = options.max_error_m.value_or(job.recorded ? kGpsError_m : kMapError_m);
  const std::vector<Sample> samples = samples_of(job.track, frame, result.greatest_distance_m);
  fit.max_elevation_error_m =
      options.max_height_error_m.value_or(job.recorded ? kGpsError_m : height_tolerance_m(samples));
  fit.closed = job.track.closed;
  fit.reject_outliers = options.reject_outliers;
  fit.tangents = options.tangents;
  fit.catmull_rom = options.catmull_rom;

  Diagnostics found;
  Result<FittedRoad> fitted = fit_road(samples, fit, &found);
  for (Diagnostic& d : found) {
    if (d.file.empty()) d.file = job.file;
    d.element = job.track.element + (job.track.element.empty() || d.element.empty() ? "" : " ") + d.element;
    result.diagnostics.push_back(std::move(d));
  }
  if (!fitted) {
    Error error = fitted.error();
    if (error.file.empty()) error.file = job.file;
    if (error.code == ErrorCode::kGeometry) error.message += "; or allow a greater error or a smaller width";
    error.element = job.track.element + (job.track.element.empty() || error.element.empty() ? "" : " ") + error.element;
    return error;
  }
  if (job.lanes) divide_into_lanes(fitted->road, *job.lanes);
  fitted->road.id = fitted->certificate.id = std::to_string(result.network.roads.size() + 1);
  fitted->road.name = job.track.name;
  result.network.roads.push_back(std::move(fitted->road));
  result.certificates.push_back(fitted->certificate);
  result.allowed_error_m.push_back(fit.max_error_m);
  result.samples.push_back(samples);
  return Done{};
}

}  // namespace

double height_tolerance_m(std::span<const Sample> samples) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const double before = glm::distance(samples[i - 1].position_m, samples[i].position_m);
    const double after = glm::distance(samples[i].position_m, samples[i + 1].position_m);
    if (!(before + after > 0)) continue;
    const double line = (samples[i - 1].elevation_m * after + samples[i + 1].elevation_m * before) / (before + after);
    sum += std::abs(samples[i].elevation_m - line);
    ++count;
  }
  const double mean = count > 0 ? sum / static_cast<double>(count) : 0;
  return std::clamp(3 * mean, kLeastHeightError_m, kGreatestHeightError_m);
}

void add_distance_warning(ImportResult& result, const std::string& path) {
  if (!(result.greatest_distance_m > kFarFromOrigin_m)) return;
  const int km = static_cast<int>(result.greatest_distance_m / 1000);
  result.diagnostics.push_back({Severity::kWarning,
                                "points lie up to " + std::to_string(km) +
                                    " km from the origin, where level lengths appear shortened by " +
                                    std::to_string(length_distortion(result.greatest_distance_m)) + " of themselves",
                                path});
}

Result<ImportResult> import_files(const std::vector<std::string>& paths, const ImportOptions& options,
                                  const Progress& progress) {
  if (Status status = check_options(paths, options); !status) return status.error();
  if (std::any_of(paths.begin(), paths.end(), is_osm_file)) {
    if (paths.size() == 1) return import_osm(paths.front(), options, progress);
    return Error{ErrorCode::kUsage, "an OSM file is imported alone; osmium merge joins several", paths.front()};
  }
  ImportResult result;
  const Result<std::vector<Track>> tracks = read_all(paths, options.fields, progress, result.diagnostics);
  if (!tracks) return tracks.error();

  // One frame for all.
  std::optional<LocalFrame> frame;
  if (tracks->front().geodetic) {
    result.network.georeference = options.origin ? *options.origin : centre_of(*tracks);
    frame.emplace(*result.network.georeference);
  } else if (options.origin) {
    return Error{ErrorCode::kUsage, "an origin is for latitudes and longitudes, but the file holds metres",
                 paths.front()};
  }
  const LocalFrame* local = frame ? &*frame : nullptr;

  const Result<std::vector<Job>> jobs = clean_all(*tracks, local, options, result.diagnostics);
  if (!jobs) return jobs.error();

  for (const Job& job : *jobs) {
    const double part = static_cast<double>(result.network.roads.size()) / static_cast<double>(jobs->size());
    if (progress) progress(0.1 + 0.9 * part, "fitting " + job.track.name);
    if (Status status = fit_into(result, job, local, options); !status) return status.error();
  }
  result.network.name = stem(paths.front());
  add_distance_warning(result, paths.front());
  if (progress) progress(1, "done");
  return result;
}

}  // namespace roadgen
