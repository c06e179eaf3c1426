// Internal: where readers of point clouds put their points.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "roadgen/import/point_cloud.h"

namespace roadgen {

class PointCloudSink {
 public:
  explicit PointCloudSink(const std::string& file) : file_(file) {}

  // line: for errors, 0 where the file has none. Errors: kData, see read_point_cloud.
  Status add(glm::dvec3 center, double radius, std::array<std::uint8_t, 4> color, int line);
  // All points, from the middle of their box. Errors: kData where there is none.
  Result<SphereSet> finish();

 private:
  static constexpr double kFarthest = 1e9;
  std::string file_;
  SphereSet set_;
  glm::dvec3 origin_{0, 0, 0}, low_{0, 0, 0}, high_{0, 0, 0};
};

Result<SphereSet> parse_ply(std::string_view bytes, const std::string& file, const PointCloudOptions& options);

}  // namespace roadgen
