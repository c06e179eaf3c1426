#include "roadgen/import/clean.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace roadgen {
namespace {

std::string joined(const std::string& element, const std::string& points) {
  return element.empty() ? points : element + " " + points;
}

void report(Diagnostics& diagnostics, Severity severity, const std::string& file, const std::string& element,
            const TrackPoint& first, const TrackPoint& last, const std::string& message) {
  diagnostics.push_back({severity, message, file, first.line, joined(element, points_text(first, last))});
}

// One repair at many points: a diagnostic for each run of consecutive ones.
class Run {
 public:
  Run(std::string file, std::string element, std::string message, Diagnostics& diagnostics)
      : file_(std::move(file)), element_(std::move(element)), message_(std::move(message)), diagnostics_(diagnostics) {}
  ~Run() { flush(); }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  void add(const TrackPoint& point) {
    if (open_ && point.index != last_.index + 1) flush();
    if (!open_) first_ = point;
    last_ = point;
    open_ = true;
  }

 private:
  void flush() {
    if (open_) report(diagnostics_, Severity::kWarning, file_, element_, first_, last_, message_);
    open_ = false;
  }

  std::string file_, element_, message_;
  Diagnostics& diagnostics_;
  TrackPoint first_, last_;
  bool open_ = false;
};

// Angle between two directions, in [0, pi].
double turn_rad(glm::dvec2 before, glm::dvec2 after) {
  return std::abs(std::atan2(before.x * after.y - before.y * after.x, glm::dot(before, after)));
}

double turn_rad(const CleanPoint& a, const CleanPoint& b, const CleanPoint& c) {
  return turn_rad(b.position_m - a.position_m, c.position_m - b.position_m);
}

bool same_place(const CleanPoint& a, const CleanPoint& b) {
  return glm::length(a.position_m - b.position_m) <= kNearDuplicate_m;
}

double distance_m(const CleanPoint& a, const CleanPoint& b) { return glm::length(a.position_m - b.position_m); }

std::vector<CleanPoint> without_repetitions(const Track& track, const std::vector<glm::dvec2>& positions_m,
                                            Diagnostics& diagnostics) {
  std::vector<CleanPoint> points;
  Run run(track.file, track.element, "within 1 cm of the point before: dropped", diagnostics);
  for (std::size_t i = 0; i < track.points.size(); ++i) {
    const CleanPoint point{positions_m[i], 0, 0, track.points[i]};
    if (points.empty() || !same_place(points.back(), point)) {
      points.push_back(point);
      continue;
    }
    TrackPoint& kept = points.back().source;
    if (!kept.height_m) kept.height_m = point.source.height_m;
    run.add(track.points[i]);
  }
  return points;
}

// Drops the points of a recorded track at which it turns sharply within the receiver's own error.
void drop_jitter(std::vector<CleanPoint>& points, const Track& track, Diagnostics& diagnostics) {
  std::vector<CleanPoint> kept;
  Run run(track.file, track.element, "sharp turn within the error of GPS, where the receiver hardly moved: dropped",
          diagnostics);
  for (const CleanPoint& point : points) {
    kept.push_back(point);
    while (kept.size() >= 3) {
      const std::size_t n = kept.size();
      const CleanPoint &before = kept[n - 3], &bend = kept[n - 2];
      const bool near = std::min(distance_m(before, bend), distance_m(bend, point)) < kJitterLeg_m;
      if (!near || turn_rad(before, bend, point) <= kJitterTurn_rad) break;
      run.add(bend.source);
      kept.erase(kept.end() - 2);
      if (!same_place(kept.end()[-2], point)) continue;
      run.add(point.source);
      kept.pop_back();
      break;
    }
  }
  points = std::move(kept);
}

// Drops single points that the track visits only to come straight back, so that it goes on as before without
// them.
void drop_excursions(std::vector<CleanPoint>& points, bool closed, const Track& track, Diagnostics& diagnostics) {
  std::vector<CleanPoint> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    kept.push_back(points[i]);
    while (kept.size() >= 3) {
      const std::size_t n = kept.size();
      const CleanPoint &before = kept[n - 3], &tip = kept[n - 2], &after = kept[n - 1];
      if (turn_rad(before, tip, after) < kReversal_rad) break;
      // Without the tip, and without a return to the very same point, does the track still turn back? Then it
      // is a way out and back, not a slip of one point.
      const bool returns = same_place(before, after);
      const CleanPoint* next = !returns ? &after : i + 1 < points.size() ? &points[i + 1] : nullptr;
      const bool turns_before = n >= 4 && next && turn_rad(kept[n - 4], before, *next) >= kReversal_rad;
      const bool turns_after =
          !returns && i + 1 < points.size() && turn_rad(before, after, points[i + 1]) >= kReversal_rad;
      if (turns_before || turns_after || !next) break;
      report(diagnostics, Severity::kWarning, track.file, track.element, tip.source, tip.source,
             "the track goes out to this point and straight back: dropped");
      kept.erase(kept.end() - 2);
      if (returns) kept.pop_back();
    }
  }
  if (closed && kept.size() > 3 && same_place(kept.front(), kept.back())) kept.pop_back();
  points = std::move(kept);
}

// Divides a track where it turns back for good. A closed one is opened there.
std::vector<CleanTrack> divided(const Track& track, std::vector<CleanPoint> points, bool closed,
                                Diagnostics& diagnostics) {
  const std::size_t n = points.size();
  std::vector<std::size_t> reversals;
  for (std::size_t i = closed ? 0 : 1; i < (closed ? n : n - 1); ++i) {
    if (n > 2 && turn_rad(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) >= kReversal_rad) {
      reversals.push_back(i);
      report(diagnostics, Severity::kWarning, track.file, track.element, points[i].source, points[i].source,
             "the track turns back on itself, which a road cannot: one road ends here and the next begins");
    }
  }
  if (reversals.empty()) return {{track.name, track.element, closed, std::move(points)}};
  if (closed) {
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(reversals.front()), points.end());
    points.push_back(points.front());
    const std::size_t origin = reversals.front();
    for (std::size_t& i : reversals) i -= origin;
    reversals.erase(reversals.begin());
  }
  std::vector<CleanTrack> pieces;
  std::size_t start = 0;
  reversals.push_back(points.size() - 1);
  for (const std::size_t end : reversals) {
    const std::string suffix = " (" + std::to_string(pieces.size() + 1) + ")";
    CleanTrack piece{track.name + suffix, track.element, false, {}};
    piece.points.assign(points.begin() + static_cast<std::ptrdiff_t>(start),
                        points.begin() + static_cast<std::ptrdiff_t>(end) + 1);
    pieces.push_back(std::move(piece));
    start = end;
  }
  return pieces;
}

void set_widths(CleanTrack& track, const std::string& file, double default_m, Diagnostics& diagnostics) {
  Run run(file, track.element, "width is not between 0.5 and 200 m: the default is used", diagnostics);
  for (CleanPoint& point : track.points) {
    const std::optional<double>& width = point.source.width_m;
    const bool good = width && *width >= kLeastWidth_m && *width <= kGreatestWidth_m;
    point.width_m = good ? *width : default_m;
    if (width && !good) run.add(point.source);
  }
}

// Why a height was taken away.
enum class Fault { kNone, kMissing, kVoid, kZero, kSpike };

const char* fault_text(Fault fault) {
  switch (fault) {
    case Fault::kMissing: return "no height: interpolated";
    case Fault::kVoid: return "height is a void value: interpolated";
    case Fault::kZero: return "height drops to zero: interpolated";
    case Fault::kSpike: return "height is a spike steeper than 100 % on both sides: interpolated";
    case Fault::kNone: break;
  }
  return "";
}

// The heights of one track on their way to repair; neighbours wrap around where the track is closed.
class Heights {
 public:
  explicit Heights(const CleanTrack& track) : track_(track), n_(track.points.size()), fault_(n_, Fault::kNone) {
    station_m_.push_back(0);
    for (std::size_t i = 0; i < n_; ++i) {
      station_m_.push_back(station_m_.back() + distance_m(track.points[i], track.points[(i + 1) % n_]));
      const std::optional<double>& height = track.points[i].source.height_m;
      value_.push_back(height.value_or(0));
      if (!height)
        fault_[i] = Fault::kMissing;
      else if (!(*height >= kLeastHeight_m && *height <= kGreatestHeight_m))
        fault_[i] = Fault::kVoid;
    }
  }

  void find_zeros() {
    const auto nonzero = [&](std::size_t i) { return fault_[i] == Fault::kNone && value_[i] != 0; };
    const Neighbours neighbours = find_neighbours(nonzero);
    const auto is_drop = [](const Neighbour& other) {
      const double drop_m = std::abs(other.height_m);
      return !other.found || (drop_m > kZeroSpike_m && drop_m > kSteepestRoad * other.distance_m);
    };
    for (std::size_t i = 0; i < n_; ++i) {
      if (fault_[i] != Fault::kNone || value_[i] != 0) continue;
      const Neighbour &before = neighbours.before[i], &after = neighbours.after[i];
      if ((before.found || after.found) && is_drop(before) && is_drop(after)) fault_[i] = Fault::kZero;
    }
  }

  // From start to end: a point that was found a spike is no neighbour any more.
  void find_spikes() {
    const Neighbours neighbours = find_neighbours([&](std::size_t i) { return fault_[i] == Fault::kNone; });
    std::size_t last = n_;
    for (std::size_t i = 0; i < n_; ++i) {
      if (fault_[i] != Fault::kNone) continue;
      Neighbour before = neighbours.before[i];
      if (last < n_) before = {true, value_[last], station_m_[i] - station_m_[last]};
      if (is_spike(i, before, neighbours.after[i]))
        fault_[i] = Fault::kSpike;
      else
        last = i;
    }
  }

  bool any_valid() const { return std::find(fault_.begin(), fault_.end(), Fault::kNone) != fault_.end(); }
  Fault fault(std::size_t i) const { return fault_[i]; }

  // Requires: any_valid().
  std::vector<double> repaired() const {
    const Neighbours neighbours = find_neighbours([&](std::size_t i) { return fault_[i] == Fault::kNone; });
    std::vector<double> heights = value_;
    for (std::size_t i = 0; i < n_; ++i) {
      if (fault_[i] == Fault::kNone) continue;
      const Neighbour &before = neighbours.before[i], &after = neighbours.after[i];
      const double whole_m = before.distance_m + after.distance_m;
      if (!before.found)
        heights[i] = after.height_m;
      else if (!after.found)
        heights[i] = before.height_m;
      else
        heights[i] = before.height_m + before.distance_m / whole_m * (after.height_m - before.height_m);
    }
    return heights;
  }

 private:
  struct Neighbour {
    bool found = false;
    double height_m = 0, distance_m = 0;  // along the track
  };
  struct Neighbours {
    std::vector<Neighbour> before, after;
  };

  bool is_spike(std::size_t i, const Neighbour& before, const Neighbour& after) const {
    if (!before.found || !after.found) return false;
    const double rise = value_[i] - before.height_m, fall = value_[i] - after.height_m;
    return rise * fall > 0 && std::abs(rise) > kSpikeGrade * before.distance_m &&
           std::abs(fall) > kSpikeGrade * after.distance_m && std::min(std::abs(rise), std::abs(fall)) > kLeastSpike_m;
  }

  // For every point the nearest others that are wanted, before and after it. Two laps around a closed track.
  template <class Wanted>
  Neighbours find_neighbours(const Wanted& wanted) const {
    Neighbours found{std::vector<Neighbour>(n_), std::vector<Neighbour>(n_)};
    const int laps = track_.closed ? 2 : 1;
    const auto scan = [&](std::vector<Neighbour>& result, bool forward) {
      std::size_t last = n_;
      double last_m = 0;
      for (int lap = 0; lap < laps; ++lap) {
        for (std::size_t k = 0; k < n_; ++k) {
          const std::size_t i = forward ? k : n_ - 1 - k;
          const double along_m = (forward ? station_m_[i] : station_m_[n_] - station_m_[i]) + lap * station_m_[n_];
          if (last < n_ && last != i) result[i] = {true, value_[last], along_m - last_m};
          if (wanted(i)) last = i, last_m = along_m;
        }
      }
    };
    scan(found.before, true);
    scan(found.after, false);
    return found;
  }

  const CleanTrack& track_;
  std::size_t n_;
  std::vector<double> station_m_;  // n + 1: the last is the length of the loop
  std::vector<double> value_;
  std::vector<Fault> fault_;
};

void repair_heights(CleanTrack& track, const std::string& file, Diagnostics& diagnostics) {
  Heights heights(track);
  heights.find_zeros();
  heights.find_spikes();
  const bool none = !heights.any_valid();
  const std::vector<CleanPoint>& points = track.points;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i + 1;
    while (end < points.size() && heights.fault(end) == heights.fault(i)) ++end;
    if (const Fault fault = heights.fault(i); fault == Fault::kMissing && none) {
      report(diagnostics, Severity::kInfo, file, track.element, points[i].source, points[end - 1].source,
             "no heights: 0 m is used");
    } else if (fault != Fault::kNone) {
      report(diagnostics, Severity::kWarning, file, track.element, points[i].source, points[end - 1].source,
             none ? "height is a void value, and there is no valid one: 0 m is used" : fault_text(fault));
    }
    i = end;
  }
  const std::vector<double> repaired = none ? std::vector<double>(points.size(), 0) : heights.repaired();
  for (std::size_t i = 0; i < points.size(); ++i) track.points[i].height_m = repaired[i];
}

}  // namespace

Status check_range(const Track& track) {
  if (!track.geodetic) return Done{};
  for (const TrackPoint& point : track.points) {
    const auto error = [&](const std::string& message) {
      return Error{ErrorCode::kParse, message, track.file, point.line,
                   joined(track.element, points_text(point, point))};
    };
    if (std::abs(point.y) > 90) {
      const bool swapped = std::abs(point.x) <= 90 && std::abs(point.y) <= 180;
      return error("latitude " + std::to_string(point.y) + " is beyond 90 degrees" +
                   (swapped ? ": latitude and longitude look swapped" : ": the file is not in degrees, or damaged"));
    }
    if (std::abs(point.x) > 180) {
      return error("longitude " + std::to_string(point.x) +
                   " is beyond 180 degrees: the file is not in degrees, or damaged");
    }
  }
  return Done{};
}

bool looks_closed(const std::vector<CleanPoint>& points) {
  if (points.size() < 4) return false;
  const CleanPoint &first = points.front(), &last = points.back();
  std::vector<double> spacing_m;
  double length_m = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    spacing_m.push_back(distance_m(points[i], points[i + 1]));
    length_m += spacing_m.back();
  }
  const double gap_m = distance_m(first, last);
  const auto median = spacing_m.begin() + static_cast<std::ptrdiff_t>(spacing_m.size() / 2);
  std::nth_element(spacing_m.begin(), median, spacing_m.end());
  if (gap_m > kNearDuplicate_m && (gap_m > 1.5 * *median || gap_m > 0.02 * length_m)) return false;

  // A way out and back along the same road ends at its start too, but is no loop.
  const CleanPoint& before = points[points.size() - 2];
  constexpr double kSharpest_rad = 2 * std::numbers::pi / 3;
  if (same_place(first, last)) return turn_rad(before, first, points[1]) < kSharpest_rad;
  return turn_rad(before, last, first) < kSharpest_rad && turn_rad(last, first, points[1]) < kSharpest_rad;
}

Result<std::vector<CleanTrack>> clean_track(const Track& track, const std::vector<glm::dvec2>& positions_m,
                                            const CleanOptions& options, Diagnostics& diagnostics) {
  assert(positions_m.size() == track.points.size());
  std::vector<CleanPoint> points = without_repetitions(track, positions_m, diagnostics);
  const bool closed = options.closed == Closed::kYes || (options.closed == Closed::kAuto && looks_closed(points));
  if (closed && points.size() > 1 && same_place(points.front(), points.back())) {
    TrackPoint& first = points.front().source;
    const std::optional<double>& last = points.back().source.height_m;
    if (!first.height_m) first.height_m = last;
    points.pop_back();
  }
  if (track.recorded) drop_jitter(points, track, diagnostics);
  if (points.size() >= 3) drop_excursions(points, closed, track, diagnostics);
  if (points.size() < (closed ? 3u : 2u)) {
    return Error{ErrorCode::kData,
                 "has " + std::to_string(points.size()) + " distinct points; " +
                     (closed ? "a closed road needs at least three" : "a road needs at least two"),
                 track.file, track.points.empty() ? 0 : track.points.front().line, track.element};
  }

  std::vector<CleanTrack> pieces = divided(track, std::move(points), closed, diagnostics);
  for (CleanTrack& piece : pieces) {
    repair_heights(piece, track.file, diagnostics);
    set_widths(piece, track.file, options.width_m, diagnostics);
  }
  return pieces;
}

}  // namespace roadgen
