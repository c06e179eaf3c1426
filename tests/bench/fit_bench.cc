// How many segments a kilometre a fit needs for a stated error: our roads against polylines and cubic Bezier curves.
//   build/release/bin/fit_bench [--errors 0.05,0.01] FILE...
// Files are those of roadgen import. For every track and error a row of a Markdown table: curves per kilometre (of a road
// those of the fit, and the segments into which the certified mapping divides them), greatest distance of a point, and
// seconds per 100,000 points. Polylines by Douglas and Peucker (1973, GEOS); Bezier curves by
// Schneider's algorithm (P. Schneider: An Algorithm for Automatically Fitting Digitized Curves, Graphics Gems, 1990).
// Segments of both count between the same points and to the same error. Times are the process's own, the least of three.
#include <geos_c.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>

#include "roadgen/fit/fit.h"
#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/clean.h"

namespace roadgen {
namespace {

using Points = std::vector<glm::dvec2>;

struct Fitted {
  std::size_t curves = 0;
  double error_m = 0;
  std::size_t segments = 0;  // of a road
};

// Distance of a point from a straight piece.
double distance_m(glm::dvec2 p, glm::dvec2 a, glm::dvec2 b) {
  const glm::dvec2 d = b - a;
  const double t = std::clamp(glm::dot(p - a, d) / std::max(glm::dot(d, d), 1e-30), 0.0, 1.0);
  return glm::distance(p, a + t * d);
}

Fitted polyline(const Points& points, double error_m) {
  GEOSContextHandle_t geos = GEOS_init_r();
  GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(geos, static_cast<unsigned>(points.size()), 2);
  for (unsigned i = 0; i < points.size(); ++i) GEOSCoordSeq_setXY_r(geos, sequence, i, points[i].x, points[i].y);
  GEOSGeometry* line = GEOSGeom_createLineString_r(geos, sequence);
  GEOSGeometry* simple = GEOSSimplify_r(geos, line, error_m);
  const GEOSCoordSequence* kept = GEOSGeom_getCoordSeq_r(geos, simple);
  unsigned count = 0;
  GEOSCoordSeq_getSize_r(geos, kept, &count);
  Points corners(count);
  for (unsigned i = 0; i < count; ++i) GEOSCoordSeq_getXY_r(geos, kept, i, &corners[i].x, &corners[i].y);
  GEOSGeom_destroy_r(geos, simple);
  GEOSGeom_destroy_r(geos, line);
  GEOS_finish_r(geos);
  Fitted fitted{count - 1, 0};
  std::size_t at = 0;
  for (const glm::dvec2& p : points) {
    if (at + 2 < corners.size() && p == corners[at + 1]) ++at;
    fitted.error_m = std::max(fitted.error_m, distance_m(p, corners[at], corners[at + 1]));
  }
  return fitted;
}

using Bezier = std::array<glm::dvec2, 4>;

glm::dvec2 value(const Bezier& b, double u) {
  const double v = 1 - u;
  return v * v * v * b[0] + 3 * v * v * u * b[1] + 3 * v * u * u * b[2] + u * u * u * b[3];
}

// Schneider's fit of the points [first, last] between two unit tangents, which point into the piece.
class BezierFit {
 public:
  BezierFit(const Points& points, double error_m) : points_(points), error_m_(error_m) {}

  Fitted run() {
    const std::size_t last = points_.size() - 1;
    const bool closed = points_.front() == points_.back();
    const glm::dvec2 through = glm::normalize(points_[1] - points_[last - 1]);
    fit(0, last, closed ? through : glm::normalize(points_[1] - points_[0]),
        closed ? -through : glm::normalize(points_[last - 1] - points_[last]));
    return result_;
  }

 private:
  static constexpr int kIterations = 20;

  void fit(std::size_t first, std::size_t last, glm::dvec2 start, glm::dvec2 end) {
    if (last - first == 1) {
      ++result_.curves;
      return;
    }
    std::vector<double> u = chord_lengths(first, last);
    std::size_t worst = first + 1;
    double error = 0;
    for (int i = 0; i <= kIterations; ++i) {
      const Bezier b = least_squares(first, last, u, start, end);
      error = 0;
      for (std::size_t k = first + 1; k < last; ++k) {
        const double d = glm::distance(value(b, u[k - first]), points_[k]);
        if (d > error) error = d, worst = k;
      }
      if (error <= error_m_) {
        ++result_.curves;
        result_.error_m = std::max(result_.error_m, error);
        return;
      }
      if (error > 16 * error_m_) break;  // no parameters will help that much
      for (std::size_t k = first + 1; k < last; ++k) u[k - first] = nearer(b, points_[k], u[k - first]);
    }
    const glm::dvec2 across = points_[worst - 1] - points_[worst + 1];
    const glm::dvec2 middle =
        glm::length(across) > 0 ? glm::normalize(across) : glm::normalize(points_[worst - 1] - points_[worst]);
    fit(first, worst, start, middle);
    fit(worst, last, -middle, end);
  }

  std::vector<double> chord_lengths(std::size_t first, std::size_t last) const {
    std::vector<double> u(last - first + 1, 0);
    for (std::size_t k = 1; k < u.size(); ++k)
      u[k] = u[k - 1] + glm::distance(points_[first + k], points_[first + k - 1]);
    for (double& x : u) x /= u.back();
    return u;
  }

  Bezier least_squares(std::size_t first, std::size_t last, const std::vector<double>& u, glm::dvec2 start,
                       glm::dvec2 end) const {
    const glm::dvec2 p0 = points_[first], p3 = points_[last];
    double c00 = 0, c01 = 0, c11 = 0, x0 = 0, x1 = 0;
    for (std::size_t k = 0; k < u.size(); ++k) {
      const double t = u[k], v = 1 - t, b1 = 3 * v * v * t, b2 = 3 * v * t * t;
      const glm::dvec2 a0 = b1 * start, a1 = b2 * end;
      const glm::dvec2 rest = points_[first + k] - (p0 * (v * v * v + b1) + p3 * (b2 + t * t * t));
      c00 += glm::dot(a0, a0), c01 += glm::dot(a0, a1), c11 += glm::dot(a1, a1);
      x0 += glm::dot(a0, rest), x1 += glm::dot(a1, rest);
    }
    const double det = c00 * c11 - c01 * c01, length = glm::distance(p0, p3);
    double left = det != 0 ? (x0 * c11 - x1 * c01) / det : 0, right = det != 0 ? (c00 * x1 - c01 * x0) / det : 0;
    if (!(left > 1e-6 * length) || !(right > 1e-6 * length)) left = right = length / 3;  // Wu and Barsky's heuristic
    return {p0, p0 + left * start, p3 + right * end, p3};
  }

  // One Newton step toward the foot of the perpendicular.
  static double nearer(const Bezier& b, glm::dvec2 p, double u) {
    const double v = 1 - u;
    const glm::dvec2 d0 = 3.0 * (b[1] - b[0]), d1 = 3.0 * (b[2] - b[1]), d2 = 3.0 * (b[3] - b[2]);
    const glm::dvec2 off = value(b, u) - p, slope = v * v * d0 + 2 * v * u * d1 + u * u * d2;
    const glm::dvec2 bend = 2.0 * (v * (d1 - d0) + u * (d2 - d1));
    const double down = glm::dot(slope, slope) + glm::dot(off, bend);
    return down != 0 ? std::clamp(u - glm::dot(off, slope) / down, 0.0, 1.0) : u;
  }

  const Points& points_;
  double error_m_;
  Fitted result_;
};

struct Line {
  std::string name;
  bool closed;
  std::vector<Sample> samples;
};

std::vector<Line> lines_of(const std::string& path) {
  Diagnostics ignored;
  const auto tracks = read_tracks(path, {}, ignored);
  if (!tracks) {
    std::fprintf(stderr, "fit_bench: %s\n", tracks.error().text().c_str());
    std::exit(1);
  }
  std::vector<Line> lines;
  for (const Track& track : *tracks) {
    std::optional<LocalFrame> frame;
    if (track.geodetic) frame.emplace(Georeference{track.points[0].y, track.points[0].x, 0});
    std::vector<glm::dvec2> positions;
    for (const TrackPoint& p : track.points) {
      positions.push_back(frame ? glm::dvec2(frame->to_local_m({p.y, p.x, 0})) : glm::dvec2(p.x, p.y));
    }
    const auto cleaned = clean_track(track, positions, {}, ignored);
    if (!cleaned) continue;
    for (const CleanTrack& piece : *cleaned) {
      Line line{stem(path), piece.closed, {}};
      for (const CleanPoint& p : piece.points) line.samples.push_back({p.position_m, 0, p.width_m / 2});
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

// The result, and the least of three times for it.
std::pair<Fitted, double> timed(const std::function<Fitted()>& work) {
  double least_s = 1e30;
  Fitted fitted;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    fitted = work();
    least_s = std::min(least_s, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return {fitted, least_s};
}

void row(const Line& line, double error_m) {
  Points points;
  for (const Sample& s : line.samples) points.push_back(s.position_m);
  if (line.closed) points.push_back(points.front());
  double length_km = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_km += glm::distance(points[i - 1], points[i]) / 1000;
  const auto ours = timed([&] {
    const auto road = fit_road(line.samples, {.max_error_m = error_m, .closed = line.closed});
    if (!road) return Fitted{};
    const Certificate& c = road->certificate;
    return Fitted{c.anchors - (line.closed ? 0 : 1), c.max_error_m, c.segments};
  });
  const auto straight = timed([&] { return polyline(points, error_m); });
  const auto bezier = timed([&] { return BezierFit(points, error_m).run(); });
  std::printf("| %s | %zu | %.0f |", line.name.substr(0, 28).c_str(), line.samples.size(), 1000 * error_m);
  std::printf(" %.1f |", static_cast<double>(ours.first.segments) / length_km);
  for (const auto& [fitted, seconds] : {ours, bezier, straight}) {
    std::printf(" %.1f | %.1f | %.2f |", static_cast<double>(fitted.curves) / length_km, 1000 * fitted.error_m,
                seconds * 1e5 / static_cast<double>(line.samples.size()));
  }
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace
}  // namespace roadgen

int main(int argc, char** argv) {
  CLI::App app("Segments per kilometre of fits of the same error");
  std::vector<double> errors = {0.05, 0.01};
  std::vector<std::string> files;
  app.add_option("--errors", errors, "Greatest distance of a point, m")->delimiter(',');
  app.add_option("FILE", files, "Tracks")->required();
  CLI11_PARSE(app, argc, argv);
  std::puts(
      "| track | points | error mm | road: segments per km | curves per km | max mm | s | Bezier: per km | max mm | s "
      "| polyline: per km | max "
      "mm | s |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
  for (const double error_m : errors) {
    for (const std::string& file : files) {
      for (const auto& line : roadgen::lines_of(file)) roadgen::row(line, error_m);
    }
  }
}
