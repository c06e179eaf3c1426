// The tables of roadgen/render/road_instance.h: cross sections and paint.
//
// A section: (borders, levels, reach of the marks: how far from its border any paints; 1 if any strip is grass), the
// heights of the levels (the first is the road surface, 0), and for each border from right to left three rows: its t as
// a cubic in s from the section's start; its mark (kind + 8 color, width, space, on); and (off, the strip to its left,
// the strip's lane id, phase of the mark). A strip: material + 8 right level + 32 left level + 128 if vehicles drive
// there. Paint: (s, t, length, width), s from the segment's start, and (kind, color, stripe, against).
#define LEVELS 4

// A texel buffer, not a storage buffer: pixels side by side read different rows, which llvmpipe fetches together from a
// texture and one by one from storage.
layout(binding = 1) uniform samplerBuffer section_table;
layout(std430, binding = 2) readonly buffer Paint { vec4 paint_rows[]; };

struct Strip {
  int material;
  int right_level;
  int left_level;
  bool driving;
  float lane;
};

vec4 section_row(uint row) { return texelFetch(section_table, int(row)); }

float section_border(uint section, int border, float ds) {
  vec4 c = section_row(section + 2u + 3u * uint(border));
  return road_cubic(ds, c.x, c.y, c.z, c.w);
}

Strip section_strip(uint section, int border) {
  vec4 row = section_row(section + 4u + 3u * uint(border));
  int code = int(row.y);
  return Strip(code & 7, (code >> 3) & 3, (code >> 5) & 3, code >= 128, row.z);
}

struct Mark {
  int kind;
  int color;
  float width;
  float space;
  float on;
  float off;
  float phase;  // what of a dash and its space has gone by where the section starts
};

Mark section_mark(uint section, int border) {
  vec4 row = section_row(section + 3u + 3u * uint(border));
  int code = int(row.x);
  vec4 rest = section_row(section + 4u + 3u * uint(border));
  return Mark(code & 7, code >> 3, row.y, row.z, row.w, rest.x, rest.w);
}
