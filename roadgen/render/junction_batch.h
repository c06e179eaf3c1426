// Internal, not installed: the junctions of a network on the GPU, drawn in one call.
#pragma once

#include "roadgen/render/box_strip.h"
#include "roadgen/road/network.h"

namespace roadgen {

class JunctionBatch {
 public:
  // Replaces what is drawn. Instances are numbered from 1 + the number of roads on.
  // Requires: problems() finds nothing in any junction. Cost: junction_surface of each; 128 bytes a junction, 64 an
  // arm, 96 a piece of a corner on the GPU.
  void upload(const Network& network);
  // Draws with the program in use, made of junction.vert and junction.frag. Requires: culled front faces.
  void draw() const;
  bool empty() const { return count_ == 0; }

 private:
  gl::VertexArray vertex_array_;
  gl::Buffer elements_, headers_, cuts_, corners_;
  GLsizei count_ = 0;
};

}  // namespace roadgen
