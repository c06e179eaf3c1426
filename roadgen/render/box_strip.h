// Internal, not installed: what boxes and quads of instances are drawn from.
#pragma once

#include <cstdint>

#include "roadgen/render/gl.h"

namespace roadgen {

// Elements of a quad and of a closed box, each one triangle strip. gl_VertexID numbers the corners: 1 at the left, 2 at the
// end, 4 at the top. A vertex that triangles share is shaded once.
inline constexpr std::uint16_t kStripElements[] = {0, 1, 2, 3, /* box */ 5, 7, 1, 3, 2, 7, 6, 5, 4, 1, 0, 2, 4, 6};

// Ranges of them, as the draw commands take them.
struct ElementRange {
  std::uint32_t first, count;
};
inline constexpr ElementRange kQuadStrip{0, 4}, kBoxStrip{4, 14};

// Requires: `elements` is destroyed after the last draw.
inline void bind_strips(const gl::VertexArray& array, gl::Buffer& elements) {
  elements = gl::Buffer::with_data(sizeof kStripElements, kStripElements);
  glVertexArrayElementBuffer(array.id(), elements.id());
}

// Draws boxes of the vertex array that is bound.
inline void draw_boxes(GLsizei instances) {
  glDrawElementsInstanced(GL_TRIANGLE_STRIP, kBoxStrip.count, GL_UNSIGNED_SHORT,
                          reinterpret_cast<const void*>(kBoxStrip.first * sizeof kStripElements[0]), instances);
}

}  // namespace roadgen
