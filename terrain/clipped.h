// A triangle or quadrangle clipped by planes, on which linear functions have their extremes at its corners.
#pragma once

#include <array>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace roadgen {

class Clipped {
 public:
  explicit Clipped(const std::array<glm::dvec3, 3>& triangle) { add(triangle); }
  explicit Clipped(const std::array<glm::dvec3, 4>& quadrangle) { add(quadrangle); }
  // Keeps what has dot(normal, p) <= limit. At most kMostPlanes times.
  static constexpr int kMostPlanes = 6;
  void clip(glm::dvec3 normal, double limit) {
    std::array<glm::dvec3, 4 + kMostPlanes> kept{};
    int n = 0;
    for (int i = 0; i < count_; ++i) {
      const glm::dvec3 &p = corners_[i], &q = corners_[(i + 1) % count_];
      const double a = limit - glm::dot(normal, p), b = limit - glm::dot(normal, q);
      if (a >= 0) kept[n++] = p;
      if ((a >= 0) != (b >= 0)) kept[n++] = p + (q - p) * (a / (a - b));
    }
    corners_ = kept;
    count_ = n;
  }
  bool empty() const { return count_ == 0; }
  glm::dvec3* begin() { return corners_.data(); }
  glm::dvec3* end() { return corners_.data() + count_; }
  const glm::dvec3* begin() const { return corners_.data(); }
  const glm::dvec3* end() const { return corners_.data() + count_; }

 private:
  template <class Points>
  void add(const Points& points) {
    for (const glm::dvec3& p : points) corners_[count_++] = p;
  }
  std::array<glm::dvec3, 4 + kMostPlanes> corners_;
  int count_ = 0;
};

}  // namespace roadgen
