// What road.vert hands to road.frag of a segment; PASS is out in one and in in the other.
#include "lib/surface.glsl"

flat PASS vec4 shape;       // L, a, b, arc length
flat PASS vec4 arc;         // c0, c1, s at the start (a float, and what it lacks)
flat PASS vec4 height;      // z1, z2, z3, s from the section's start
flat PASS uvec4 ids;        // road, section, paint, flags
flat PASS vec2 axis;        // unit chord direction in ENU
PASS vec3 relative;         // position relative to the eye, ENU
#ifdef RELIEF
flat PASS vec4 superelevation;
flat PASS vec4 crossfall;   // left at the start and its slope, right
flat PASS vec4 box;
flat PASS vec3 eye;         // in chord axes, metres from the start anchor
flat PASS vec3 extent;      // the most that the surface bends along a line, 1/m; its fold at the reference line; what no
                            // part of the road is farther than from that, m
PASS vec3 point;            // likewise
#else
PASS vec2 chord_point;      // x, y in the chord frame
PASS vec3 linear;           // alpha, beta, gamma: linear in x and y, so the rasterizer interpolates them
#endif

RoadSurface road_surface() {
#ifdef RELIEF
  return RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z, superelevation.x,
                     superelevation.y, superelevation.z, superelevation.w, crossfall.x, crossfall.y, crossfall.z,
                     crossfall.w);
#else
  return RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z, 0.0, 0.0, 0.0, 0.0,
                     0.0, 0.0, 0.0, 0.0);
#endif
}
