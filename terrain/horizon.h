// What ground is hidden by nearer ground, for an eye above it: by azimuth, how high the ground that has been drawn rises.
//
// The circle about the eye is cut into sectors. A triangle whose sides enclose a whole sector hides there whatever lies
// behind it and below its lowest corner: a height field has no ground above another's. So do, together, all that a coarser
// triangle was halved into, which enclose more sectors. Asked from near to far, a triangle is hidden where its highest
// point may rise in all of its sectors to less than what is before it. Through portals of tunnels one sees beyond: sectors
// that touch those stay open.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace roadgen {

class Horizon {
 public:
  Horizon() : rise_(kSectors) {}
  // Begins anew, with nothing hidden. pixel_rad: the angle of a pixel; nearest_drawn_m: what is nearer to the eye may not be
  // drawn, and hides nothing.
  void begin(glm::dvec3 eye_m, double pixel_rad, double nearest_drawn_m);
  // Nothing will be hidden: the eye is not above the ground.
  void disable() { is_on_ = false; }
  bool is_on() const { return is_on_; }
  glm::dvec3 eye_m() const { return eye_m_; }

  // Where a triangle lies from the eye.
  struct Sight {
    bool is_about_eye = false;   // over or under it; then the rest is nothing
    double first = 0, last = 0;  // azimuth, in sectors; last may go beyond the circle
    double nearest_m = 0, farthest_m = 0;
  };
  // Of a right triangle, whose hypotenuse runs from left to right, seen in plan. ENU, m.
  Sight sight(glm::dvec2 apex_m, glm::dvec2 left_m, glm::dvec2 right_m) const;
  // Whether what is nowhere higher than this is hidden.
  bool hides(const Sight& sight, double highest_m) const;
  // Ground was drawn all over the triangle, nowhere lower than this.
  void add(const Sight& sight, double lowest_m);
  // Behind the triangle nothing will be hidden.
  void open(const Sight& sight);

 private:
  // 0.09 to 0.18 degrees each.
  static constexpr std::uint32_t kSectors = 4096;
  // What is hidden is so by this much, in pixels: the rasterizer moves vertices by up to 1/256.
  static constexpr double kSlack = 1.0 / 64;

  bool is_on_ = false;
  glm::dvec3 eye_m_{0, 0, 0};
  double slack_rad_ = 0, nearest_drawn_m_ = 0;
  std::vector<float> rise_;  // of each sector: height over distance from the eye, at least; infinity, negative: nothing
                             // known; no number: open
};

}  // namespace roadgen
