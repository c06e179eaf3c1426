#include "roadgen/import/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kWide = 960, kPlanHigh = 640, kPlotHigh = 170, kLeft = 66, kRight = 14, kTop = 10, kBottom = 34;
constexpr int kCurvePoints = 800;
constexpr const char* kUntold = "#667788";  // no points are known

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

// Where a sample lies against its road: s, and its distance, positive on the left.
struct Place {
  double s_m = 0, offset_m = 0;
  std::size_t segment = 0;
};

// Samples follow one another along the road, so each is looked for about the segment of the one before, and everywhere
// only where that is no good.
std::vector<Place> places_of(const Road& road, const std::vector<Sample>& samples) {
  constexpr std::size_t kBack = 3, kAhead = 12;
  const std::size_t count = road.segments.size();
  std::vector<Place> places;
  places.reserve(samples.size());
  std::size_t last = 0;
  for (const Sample& sample : samples) {
    double least = std::numeric_limits<double>::infinity();
    Place place;
    const auto offer = [&](std::size_t i) {
      const Segment& segment = road.segments[i];
      const Nearest near = nearest(segment, sample.position_m);
      if (near.distance_m >= least) return;
      least = near.distance_m;
      const glm::dvec2 p = to_chord(segment, sample.position_m);
      const bool left = p.y > Lib::road_f(near.u, segment.slope_start, segment.slope_end);
      place = {segment.s_start_m + arc_at(segment, near.u), left ? least : -least, i};
    };
    for (std::size_t k = 0; k <= std::min(kBack + kAhead, count - 1); ++k)
      offer((last + count - std::min(kBack, count - 1) + k) % count);
    if (least > 0.5 * road.segments[last].chord_length_m()) {
      for (std::size_t i = 0; i < count; ++i) offer(i);
    }
    last = place.segment;
    places.push_back(place);
  }
  return places;
}

// A round number near the given one: 1, 2 or 5 times a power of ten, not more.
double round_step(double about) {
  const double power = std::pow(10, std::floor(std::log10(about)));
  const double part = about / power;
  return (part < 2 ? 1 : part < 5 ? 2 : 5) * power;
}

// Part of the allowed error to a colour: green, yellow at a half, red at all of it.
std::string colour(double part) {
  return fmt::format("hsl({:.0f},75%,{:.0f}%)", 130 * (1 - std::clamp(part, 0.0, 1.0)), 38 + 6 * std::min(part, 1.0));
}

struct Curve {
  std::string colour;
  bool dots = false;
  std::vector<glm::dvec2> points;
};

// A plot over s with axes, round ticks and units.
std::string plot(const std::string& title, double length_m, const std::vector<Curve>& curves,
                 const std::vector<double>& limits) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Curve& curve : curves) {
    for (const glm::dvec2& p : curve.points) low = std::min(low, p.y), high = std::max(high, p.y);
  }
  for (const double y : limits) low = std::min(low, y), high = std::max(high, y);
  if (!(low <= high)) low = high = 0;
  const double room = std::max(0.06 * (high - low), 1e-6 * std::max(1.0, std::abs(high)));
  low -= room, high += room;
  const double x_scale = (kWide - kLeft - kRight) / length_m, y_scale = (kPlotHigh - kTop - kBottom) / (high - low);
  const auto x_of = [&](double s) { return kLeft + s * x_scale; };
  const auto y_of = [&](double y) { return kPlotHigh - kBottom - (y - low) * y_scale; };
  std::string svg =
      fmt::format("<svg width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}'>\n", kWide, kPlotHigh);
  auto out = std::back_inserter(svg);
  const double y_step = round_step((high - low) / 3);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(y_step) + 1e-9)));
  for (double y = std::ceil(low / y_step) * y_step; y <= high; y += y_step) {
    fmt::format_to(out, "<line class='grid' x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}'/>", kLeft, y_of(y),
                   kWide - kRight, y_of(y));
    fmt::format_to(out, "<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{:.{}f}</text>\n", kLeft - 6, y_of(y) + 4,
                   std::abs(y) < 1e-9 * y_step ? 0.0 : y, decimals);
  }
  const double x_step = round_step(length_m / 6);
  for (double s = 0; s <= length_m * (1 + 1e-9); s += x_step) {
    fmt::format_to(out, "<line class='grid' x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}'/>", x_of(s), kTop,
                   kPlotHigh - kBottom);
    fmt::format_to(out, "<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{:g}</text>\n", x_of(s),
                   kPlotHigh - kBottom + 15, s);
  }
  fmt::format_to(out, "<text x='{:.1f}' y='{:.1f}' text-anchor='end'>s, m</text>", kWide - kRight, kPlotHigh - 4);
  fmt::format_to(out, "<text x='{:.1f}' y='{:.1f}' class='title'>{}</text>\n", kLeft, kPlotHigh - 4, escaped(title));
  for (const double y : limits) {
    fmt::format_to(out, "<line class='limit' x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}'/>\n", kLeft, y_of(y),
                   kWide - kRight, y_of(y));
  }
  for (const Curve& curve : curves) {
    if (curve.dots) {
      fmt::format_to(out, "<g fill='{}'>", curve.colour);
      for (const glm::dvec2& p : curve.points)
        fmt::format_to(out, "<circle cx='{:.1f}' cy='{:.1f}' r='1.6'/>", x_of(p.x), y_of(p.y));
      svg += "</g>\n";
    } else {
      fmt::format_to(out, "<polyline fill='none' stroke='{}' stroke-width='1.3' points='", curve.colour);
      for (const glm::dvec2& p : curve.points) fmt::format_to(out, "{:.1f},{:.1f} ", x_of(p.x), y_of(p.y));
      svg += "'/>\n";
    }
  }
  return svg + "</svg>\n";
}

// A value along the road, at kCurvePoints places at most and at both ends of every segment that has room.
std::vector<glm::dvec2> along(const Road& road, const std::function<double(const Segment&, double local_s_m)>& value) {
  const double length = road.length_m(), step = std::max(length / kCurvePoints, 0.01);
  std::vector<glm::dvec2> points;
  for (const Segment& segment : road.segments) {
    const int pieces = std::max(1, static_cast<int>(segment.arc_m / step));
    for (int i = 0; i <= pieces; ++i) {
      const double s = segment.arc_m * i / pieces;
      points.emplace_back(segment.s_start_m + s, value(segment, s));
    }
  }
  return points;
}

// Every k-th, so that there are not many more than kCurvePoints; the first and every greatest of its group are kept.
std::vector<glm::dvec2> thinned(const std::vector<glm::dvec2>& points) {
  const std::size_t group = (points.size() + kCurvePoints - 1) / kCurvePoints;
  if (group <= 1) return points;
  std::vector<glm::dvec2> kept;
  for (std::size_t i = 0; i < points.size(); i += group) {
    const auto end = points.begin() + static_cast<std::ptrdiff_t>(std::min(i + group, points.size()));
    kept.push_back(*std::max_element(points.begin() + static_cast<std::ptrdiff_t>(i), end,
                                     [](glm::dvec2 a, glm::dvec2 b) { return std::abs(a.y) < std::abs(b.y); }));
  }
  return kept;
}

class Page {
 public:
  explicit Page(const ImportResult& result) : result_(result) {
    const auto& roads = result.network.roads;
    for (std::size_t i = 0; i < roads.size(); ++i) {
      const bool known = i < result.samples.size() && !roads[i].segments.empty();
      places_.push_back(known ? places_of(roads[i], result.samples[i]) : std::vector<Place>{});
    }
  }

  std::string text() {
    html_ =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>Import report</title><style>\n"
        "body{font:14px sans-serif;margin:24px;color:#222;max-width:1100px}\n"
        "table{border-collapse:collapse;font-size:13px}td,th{padding:3px 9px;text-align:right;border-bottom:1px solid "
        "#ddd}\ntd:nth-child(-n+2),th:nth-child(-n+2){text-align:left}\nsvg{background:#fff;border:1px solid "
        "#ccc;margin:4px 0;display:block}\nsvg text{font:11px sans-serif;fill:#444}svg text.title{font-weight:bold}\n"
        ".grid{stroke:#e4e4e4}.limit{stroke:#c33;stroke-dasharray:5 4}\n</style></head><body>\n<h1>Import "
        "report</h1>\n";
    table();
    plan();
    plots();
    diagnostics();
    return html_ + "</body></html>\n";
  }

 private:
  template <class... Values>
  void put(fmt::format_string<Values...> text, Values&&... values) {
    fmt::format_to(std::back_inserter(html_), text, std::forward<Values>(values)...);
  }
  double part_of_allowed(std::size_t i) const {
    return result_.certificates[i].max_error_m / result_.allowed_error_m[i];
  }

  void left_out(std::size_t count, const char* what) {
    if (count > 0) put("<p>{} more {} are left out here; the JSON report has them all.</p>\n", count, what);
  }

  void table() {
    const auto& all = result_.certificates;
    put("<table><tr><th>road</th><th>name</th><th>closed</th><th>length, m</th><th>points</th><th>segments</th><th>per "
        "km</th><th>greatest error, m</th><th>RMS, m</th><th>allowed, m</th><th>proven bound, m</th><th>source to "
        "road, "
        "m</th><th>road to source, m</th><th>height error, m</th><th>left out</th></tr>\n");
    for (std::size_t i = 0; i < std::min(all.size(), kMostRows); ++i) {
      const Certificate& c = all[i];
      put("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td><td>{}</td><td>{}</td><td>{:.1f}</td><td>{:.4f}</td>"
          "<td>{:.4f}</td><td>{:.3f}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.3f}</td><td>{}</td></"
          "tr>\n",
          escaped(c.id), escaped(result_.network.roads[i].name), c.closed ? "yes" : "no", c.length_m, c.samples,
          c.segments, 1000 * static_cast<double>(c.segments) / std::max(c.length_m, 1e-9), c.max_error_m, c.rms_error_m,
          result_.allowed_error_m[i], c.bound_m, c.source_to_curve_m, c.curve_to_source_m, c.max_elevation_error_m,
          c.outliers);
    }
    html_ += "</table>\n";
    left_out(all.size() - std::min(all.size(), kMostRows), "roads");
  }

  bool is_told(std::size_t i) const { return !places_[i].empty() && i < result_.allowed_error_m.size(); }

  template <class At>
  void segments_in_plan(std::size_t i, const At& at) {
    const Road& road = result_.network.roads[i];
    std::vector<double> error(road.segments.size(), 0);
    for (const Place& p : places_[i]) error[p.segment] = std::max(error[p.segment], std::abs(p.offset_m));
    for (std::size_t k = 0; k < road.segments.size(); ++k) {
      const Segment& segment = road.segments[k];
      const double bow = glm::distance(at(segment.start_m), at(segment.end_m)) *
                         (std::abs(segment.slope_start) + std::abs(segment.slope_end));
      const int pieces = std::clamp(static_cast<int>(std::sqrt(bow)) + 1, 1, 12);
      put("<path stroke='{}' d='M", is_told(i) ? colour(error[k] / result_.allowed_error_m[i]) : kUntold);
      for (int j = 0; j <= pieces; ++j) {
        const glm::dvec2 p = at(position_m(segment, static_cast<double>(j) / pieces));
        put("{:.1f} {:.1f} ", p.x, p.y);
      }
      html_ += "'/>\n";
    }
  }

  // One line through the anchors that lie a pixel apart, in the colour of its worst point.
  template <class At>
  void road_in_plan(std::size_t i, const At& at) {
    const Road& road = result_.network.roads[i];
    if (road.segments.empty()) return;
    put("<path stroke='{}' d='M", is_told(i) ? colour(part_of_allowed(i)) : kUntold);
    glm::dvec2 last = at(road.segments[0].start_m);
    put("{:.1f} {:.1f} ", last.x, last.y);
    for (const Segment& segment : road.segments) {
      const glm::dvec2 p = at(segment.end_m);
      if (glm::distance(p, last) < 1 && &segment != &road.segments.back()) continue;
      put("{:.1f} {:.1f} ", p.x, p.y);
      last = p;
    }
    html_ += "'/>\n";
  }

  void plan() {
    const Bounds box = bounds(result_.network);
    const glm::dvec2 low(box.low_m), size = glm::max(glm::dvec2(box.high_m) - low, 1.0);
    const double scale = std::min((kWide - 40) / size.x, (kPlanHigh - 70) / size.y);
    const glm::dvec2 rest = 0.5 * (glm::dvec2(kWide, kPlanHigh - 30) - scale * size);
    const auto at = [&](glm::dvec2 p) {
      const glm::dvec2 q = rest + scale * (p - low);
      return glm::dvec2(q.x, kPlanHigh - 30 - q.y);
    };
    html_ += "<h2>Plan</h2>\n";
    put("<svg width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}'>\n<g fill='none' stroke-width='2'>\n",
        kWide, kPlanHigh);
    const bool coarse = result_.network.segment_count() > kMostPlannedSegments;
    for (std::size_t i = 0; i < result_.network.roads.size(); ++i)
      coarse ? road_in_plan(i, at) : segments_in_plan(i, at);
    html_ += "</g>\n";
    const double bar = round_step(0.25 * (kWide - 40) / scale);
    put("<path stroke='#222' fill='none' d='M20 {0:.1f} v6 h{1:.1f} v-6'/><text x='{2:.1f}' y='{3:.1f}'>{4:g} "
        "m</text>\n",
        kPlanHigh - 24, bar * scale, 26 + bar * scale, kPlanHigh - 16, bar);
    put("<path d='M{0:.1f} 40 l6 14 l-6 -4 l-6 4 z' fill='#222'/><text x='{0:.1f}' y='34' "
        "text-anchor='middle'>N</text>\n",
        kWide - 30);
    for (int i = 0; i <= 4; ++i) {
      put("<rect x='{:.1f}' y='{:.1f}' width='26' height='10' fill='{}'/>", kWide - 330 + 30 * i, kPlanHigh - 26,
          colour(0.25 * i));
    }
    put("<text x='{:.1f}' y='{:.1f}'>0 to 100 % of the allowed error</text>\n</svg>\n", kWide - 174, kPlanHigh - 17);
  }

  void plots() {
    std::vector<std::size_t> order(std::min(result_.certificates.size(), result_.network.roads.size()));
    std::iota(order.begin(), order.end(), 0);
    std::erase_if(order, [&](std::size_t i) { return result_.network.roads[i].segments.empty(); });
    const std::size_t all = order.size();
    if (all > kMostPlottedRoads) {
      std::stable_sort(order.begin(), order.end(),
                       [&](std::size_t a, std::size_t b) { return part_of_allowed(a) > part_of_allowed(b); });
      order.resize(kMostPlottedRoads);
    }
    for (const std::size_t i : order) plots_of(i);
    left_out(all - order.size(), "roads' plots");
  }

  void plots_of(std::size_t i) {
    const Road& road = result_.network.roads[i];
    const double length = road.length_m(), allowed = result_.allowed_error_m[i];
    put("<h2>Road {} {}</h2>\n", escaped(road.id), escaped(road.name));
    std::vector<glm::dvec2> offsets, heights;
    for (std::size_t k = 0; k < places_[i].size(); ++k) {
      offsets.emplace_back(places_[i][k].s_m, places_[i][k].offset_m);
      heights.emplace_back(places_[i][k].s_m, result_.samples[i][k].elevation_m);
    }
    if (!offsets.empty()) {
      html_ += plot("points left of the road, m; dashed: allowed", length, {{"#2563a8", true, thinned(offsets)}},
                    {-allowed, allowed});
    }
    html_ += plot("curvature, 1/m; left is positive", length,
                  {{"#2563a8", false,
                    along(road, [](const Segment& g, double s) { return curvature_per_m(g, u_at_arc(g, s)); })}},
                  {});
    std::vector<Curve> elevation = {
        {"#a85a25", false, along(road, [](const Segment& g, double s) { return g.elevation_m.value(s); })}};
    if (!heights.empty()) elevation.insert(elevation.begin(), {"#999", true, thinned(heights)});
    html_ += plot("elevation, m; grey: points", length, elevation, {});
  }

  void diagnostics() {
    const Diagnostics& all = result_.diagnostics;
    if (all.empty()) return;
    html_ += "<h2>Diagnostics</h2>\n<ul>\n";
    for (std::size_t i = 0; i < std::min(all.size(), kMostRows); ++i) put("<li>{}</li>\n", escaped(text_of(all[i])));
    html_ += "</ul>\n";
    left_out(all.size() - std::min(all.size(), kMostRows), "diagnostics");
  }
  static std::string text_of(const Diagnostic& d) {
    std::string where = d.file;
    if (d.line > 0) where += ":" + std::to_string(d.line);
    if (!d.element.empty()) where += (where.empty() ? "" : ", ") + d.element;
    return where.empty() ? d.message : where + ": " + d.message;
  }

  const ImportResult& result_;
  std::vector<std::vector<Place>> places_;  // of each road's samples
  std::string html_;
};

}  // namespace

std::string import_html(const ImportResult& result) { return Page(result).text(); }

}  // namespace roadgen
