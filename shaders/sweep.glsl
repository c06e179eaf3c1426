// What both stages of a sweep read: SweepInstance of roadgen/render/sweep_batch.cc.
struct SweepInstance {
  vec4 start_high;  // start anchor, ENU, as two floats; index of the road
  vec4 start_low;   // s of the segment's start from the sweep's start, m
  vec4 shape;       // chord x, y (m), slopes a, b
  vec4 arc;         // arc length (m), c0, c1; spacing of the lamps (m, 0: none)
  vec4 axis;        // z0, z1, z2, z3
  vec4 place;       // n0, n1, u0, u1
  vec4 box;         // y0, y1, z0, z1: m from the start anchor, chord axes
  vec4 profile;     // p0 to p3
  vec4 bends;       // p4, p5; bend_n, bend_h
  vec4 kinds;       // bend_s; profile's kind; s from the segment's start to the sweep's end; phase of the noise along s
  vec4 posts;       // first, spacing, count, half_s
  vec4 post;        // half_n, n, low, high
  vec4 albedo;      // linear; w: 1 metal
  vec4 ends;        // end0, end1
};
layout(std430, binding = 3) readonly buffer Sweeps { SweepInstance sweeps[]; };
