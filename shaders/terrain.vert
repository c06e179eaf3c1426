// The ground: a triangle mesh relative to its tile's origin.
#include "frame.glsl"

layout(location = 0) in vec3 in_position;  // relative to the tile's origin, m
layout(location = 1) in vec3 in_normal;
layout(location = 2) in float in_road;     // distance from the nearest carriageway, m, up to 16
layout(location = 3) in vec3 tile;         // the tile's origin, relative to a place near the eye, m

layout(location = 0) uniform vec3 place_from_eye;

out vec3 relative;
out vec3 ground_normal;
out float road_m;
#ifdef HOLLOWS
out vec3 in_tile;
#endif

void main() {
  // Vertices of two tiles are the same to the bit: what the first sum adds is exact.
  relative = (in_position + tile) + place_from_eye;
  ground_normal = in_normal;
  road_m = in_road;
#ifdef HOLLOWS
  in_tile = in_position;
#endif
  gl_Position = clip_from_relative * vec4(relative, 1.0);
}
