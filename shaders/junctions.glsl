// The junctions of the scene, as roadgen/render/junction_batch.cc uploads them. Coordinates from each one's centre.
struct JunctionHeader {
  vec4 center_high;  // ENU, as two floats
  vec4 center_low;
  vec4 low;          // bounds of the area and its surface; w: greatest height of the surface off the plane
  vec4 high;
  vec4 plane;        // a plane near the surface: slopes along x and y, height at the centre; w: how much the surface's
                     // slope departs from it
  vec4 phase;        // xy: centre modulo NOISE_PERIOD; z: how far the area reaches under the strips at its corners
  uvec4 range;       // first cut, number of cuts, first corner piece, number of corner pieces
  uvec4 ids;         // index of the junction, instance
};
layout(std430, binding = 3) readonly buffer JunctionHeaders { JunctionHeader headers[]; };
layout(std430, binding = 4) readonly buffer JunctionCuts { vec4 cut_rows[]; };        // 4 a cut
layout(std430, binding = 5) readonly buffer JunctionCorners { vec4 corner_rows[]; };  // 6 a piece
