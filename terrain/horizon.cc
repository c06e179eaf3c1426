#include "terrain/horizon.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kEdge = 1e-6;  // of a sector, lest rounding takes one for enclosed

// A measure of azimuth without trigonometry: 0 to 4, from south by east. Opposite directions differ by 2.
double azimuth(glm::dvec2 d) {
  const double part = d.y / (std::abs(d.x) + std::abs(d.y));
  return d.x >= 0 ? 1 + part : 3 - part;
}

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

}  // namespace

void Horizon::begin(glm::dvec3 eye_m, double pixel_rad, double nearest_drawn_m) {
  is_on_ = true;
  eye_m_ = eye_m;
  slack_rad_ = kSlack * pixel_rad + 1e-6;
  nearest_drawn_m_ = nearest_drawn_m;
  std::fill(rise_.begin(), rise_.end(), -std::numeric_limits<float>::infinity());
}

Horizon::Sight Horizon::sight(glm::dvec2 apex_m, glm::dvec2 left_m, glm::dvec2 right_m) const {
  const glm::dvec2 eye(eye_m_), a = apex_m - eye, l = left_m - eye, r = right_m - eye;
  // The circle through the corners is about the hypotenuse's middle.
  const double middle = 0.5 * glm::length(l + r), radius = 0.5 * glm::length(r - l);
  Sight s;
  const double least = -1e-9 * radius * radius;
  s.is_about_eye = cross(a, l) >= least && cross(l, r) >= least && cross(r, a) >= least;
  if (s.is_about_eye) return s;
  s.nearest_m = std::max(middle - radius, 0.0);
  s.farthest_m = middle + radius;
  double corners[3] = {azimuth(a), azimuth(l), azimuth(r)};
  const double most = std::max({corners[0], corners[1], corners[2]});
  s.first = s.last = most;
  for (double& c : corners) {
    if (most - c > 2) c += 4;  // across the circle's end
    s.first = std::min(s.first, c);
    s.last = std::max(s.last, c);
  }
  s.first *= kSectors / 4;
  s.last *= kSectors / 4;
  return s;
}

bool Horizon::hides(const Sight& sight, double highest_m) const {
  if (!is_on_ || sight.is_about_eye || !(sight.nearest_m > 0)) return false;
  const double up = highest_m - eye_m_.z;
  const double steep = up / (up > 0 ? sight.nearest_m : sight.farthest_m);
  // An angle is the more of height and azimuth the further it is from level. The measure of azimuth grows by at most 1 a
  // radian.
  const double rise = steep + slack_rad_ * (1 + steep * steep);
  const double edge = kEdge + slack_rad_ * std::sqrt(1 + steep * steep) * kSectors / 4;
  const auto last = static_cast<std::int64_t>(std::floor(sight.last + edge));
  for (auto i = static_cast<std::int64_t>(std::floor(sight.first - edge)); i <= last; ++i) {
    if (!(rise < rise_[static_cast<std::size_t>(i) % kSectors])) return false;
  }
  return true;
}

void Horizon::add(const Sight& sight, double lowest_m) {
  if (!is_on_ || sight.is_about_eye || !(sight.nearest_m > nearest_drawn_m_)) return;
  const double up = lowest_m - eye_m_.z;
  const auto rise = static_cast<float>(up / (up > 0 ? sight.farthest_m : sight.nearest_m));
  const auto end = static_cast<std::int64_t>(std::floor(sight.last - kEdge));
  for (auto i = static_cast<std::int64_t>(std::ceil(sight.first + kEdge)); i < end; ++i) {
    float& known = rise_[static_cast<std::size_t>(i) % kSectors];
    if (rise > known) known = rise;  // not where it is no number
  }
}

void Horizon::open(const Sight& sight) {
  if (sight.is_about_eye) disable();
  const auto last = static_cast<std::int64_t>(std::floor(sight.last + kEdge));
  for (auto i = static_cast<std::int64_t>(std::floor(sight.first - kEdge)); i <= last; ++i) {
    rise_[static_cast<std::size_t>(i + kSectors) % kSectors] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace roadgen
