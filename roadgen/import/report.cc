#include <nlohmann/json.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/import.h"

namespace roadgen {
namespace {

using Json = nlohmann::ordered_json;

Json certificate_json(const Certificate& c, const Road& road, double allowed_error_m) {
  return {{"id", c.id},
          {"name", road.name},
          {"closed", c.closed},
          {"length_m", c.length_m},
          {"samples", c.samples},
          {"anchors", c.anchors},
          {"segments", c.segments},
          {"allowed_error_m", allowed_error_m},
          {"max_error_m", c.max_error_m},
          {"rms_error_m", c.rms_error_m},
          {"bound_m", c.bound_m},
          {"source_to_curve_m", c.source_to_curve_m},
          {"curve_to_source_m", c.curve_to_source_m},
          {"max_elevation_error_m", c.max_elevation_error_m},
          {"outliers", c.outliers},
          {"greatest_outlier_m", c.greatest_outlier_m},
          {"max_heading_jump_rad", c.max_heading_jump_rad},
          {"max_curvature_jump_per_m", c.max_curvature_jump_per_m}};
}

Json at_json(const AtRoad& at) { return {{"road", at.road}, {"s_m", at.s_m}}; }

Json heights_json(const HeightFitReport& h) {
  return {{"samples", h.samples},
          {"samples_missing", h.samples_missing},
          {"rms_m", h.rms_m},
          {"mean_abs_m", h.mean_abs_m},
          {"highest_fill_m", h.highest_fill_m},
          {"highest_fill_at", at_json(h.highest_fill_at)},
          {"deepest_cut_m", h.deepest_cut_m},
          {"deepest_cut_at", at_json(h.deepest_cut_at)},
          {"max_grade", h.max_grade},
          {"max_grade_at", at_json(h.max_grade_at)},
          {"max_curvature_per_m", h.max_curvature_per_m},
          {"max_curvature_at", at_json(h.max_curvature_at)},
          {"roads", h.roads},
          {"roads_over_grade", h.over_grade},
          {"roads_over_curvature", h.over_curvature},
          {"passings", h.passings},
          {"passings_short", h.passings_short},
          {"least_passing_m", h.least_passing_m}};
}

}  // namespace

std::string import_report(const ImportResult& result) {
  Json report;
  if (const auto& origin = result.network.georeference) {
    report["origin"] = {{"latitude_deg", origin->latitude_deg},
                        {"longitude_deg", origin->longitude_deg},
                        {"height_m", origin->height_m}};
    report["length_distortion"] = length_distortion(result.greatest_distance_m);
  }
  report["roads"] = Json::array();
  for (std::size_t i = 0; i < result.certificates.size(); ++i) {
    report["roads"].push_back(
        certificate_json(result.certificates[i], result.network.roads[i], result.allowed_error_m[i]));
  }
  if (result.heights) report["heights"] = heights_json(*result.heights);
  report["diagnostics"] = Json::array();
  for (const Diagnostic& d : result.diagnostics) {
    report["diagnostics"].push_back({{"severity", severity_name(d.severity)},
                                     {"file", d.file},
                                     {"line", d.line},
                                     {"element", d.element},
                                     {"message", d.message}});
  }
  return report.dump(2) + "\n";
}

}  // namespace roadgen
