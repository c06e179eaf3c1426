// Internal, not installed: the pieces of all sweeps on the GPU, and their draw.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/render/box_strip.h"
#include "roadgen/render/program.h"
#include "roadgen/road/network.h"

namespace roadgen {

class SweepBatch {
 public:
  // Replaces the sweeps by the network's. Cost: O(pieces); 224 bytes each on the GPU.
  void upload(const Network& network);
  // Draws the pieces that may_see allows (centre from the eye, radius), far to near, so that their edges fade over what
  // lies behind. Requires: depth test on, the frame's uniforms bound. Cost: a sort of the pieces seen.
  void draw(const Program& program, glm::dvec3 eye_m, const std::function<bool(glm::dvec3, double)>& may_see);

 bool empty() const { return balls_.empty(); }

 private:
  struct Ball {
    glm::dvec3 center_m;
    double radius_m;
  };
  gl::VertexArray vertex_array_;
  gl::Buffer elements_, instances_, order_;
  std::vector<Ball> balls_;
};

}  // namespace roadgen
