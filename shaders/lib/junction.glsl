// The carriageway of a junction: an area bounded by the cut lines of its arms and by corner curves (cubics, road.glsl),
// and a surface over it. Both come from pieces that are added one by one, since the pieces stand in a buffer.
// Frame: x east, y north, z up, in metres from the junction's centre. Needs road.glsl. C++: roadgen/road/junction.h.

// Where a road ends at the junction. Looking into the junction, n is the offset to the left of the reference line.
struct JunctionCut {
  float x0;          // left end of the cut, n = left
  float y0;
  float x1;          // right end, n = right
  float y1;
  float left;        // >= 0
  float right;       // <= 0, less than left
  float z;           // height of the reference line at the cut
  float grade;       // dz per metre into the junction
  float tilt;        // dz per metre to the left
  float fall_left;   // slope falling away from the reference line, on the left
  float fall_right;  // and on the right
};

// A piece of a corner curve; the area lies on its left.
struct JunctionCorner {
  float x0;       // start
  float y0;
  float y1;       // y of the end
  float chord;    // length, and unit direction
  float cx;
  float cy;
  float a;        // slopes against the chord
  float b;
  float arc;      // arc length, and the inner coefficients of road_arc
  float c0;
  float c1;
  float z0;       // height: cubic in s
  float z1;
  float z2;
  float z3;
  float along0;   // slopes of the surface along and across the chord, per metre, at the start,
  float across0;
  float along1;   // and at the end
  float across1;
  float fall0;    // further rise toward the inside by the arms' crossfall, at the start,
  float fall1;    // and at the end; both per metre across the chord: times cos(atan(slope))
};

// The weighted mean of the pieces' surfaces so far, with gradients.
struct JunctionHeight {
  float w;   // sum of the weights
  float wx;
  float wy;
  float z;   // height
  float zx;  // dz/dx
  float zy;
};

FN JunctionHeight junction_height_begin() {
  JunctionHeight h;
  h.w = float(0.0);
  h.wx = float(0.0);
  h.wy = float(0.0);
  h.z = float(0.0);
  h.zx = float(0.0);
  h.zy = float(0.0);
  return h;
}

// Shepard's interpolation with the weight length / d^2 of a piece of that length at the distance d (Shepard 1968):
// on a piece all others have vanished to second order, so the mean meets the piece's surface in height and slope.
// d is kept above a millimetre, so nothing is infinite on the piece itself; the others' part there is 1e-6 m^2 / d^2.
FN JunctionHeight junction_height_add(IN(JunctionHeight) h, IN(float) length_m, IN(float) d2, IN(float) d2x,
                                      IN(float) d2y, IN(float) z, IN(float) zx, IN(float) zy) {
  float q = 1.0 / (d2 + 1e-6);
  float w = length_m * q;
  float wx = -w * q * d2x;
  float wy = -w * q * d2y;
  JunctionHeight mean;
  mean.w = h.w + w;
  mean.wx = h.wx + wx;
  mean.wy = h.wy + wy;
  float share = 1.0 / mean.w;
  float part = w * share;
  float rise = z - h.z;
  mean.z = h.z + part * rise;
  mean.zx = h.zx + (wx * h.w - w * h.wx) * share * share * rise + part * (zx - h.zx);
  mean.zy = h.zy + (wy * h.w - w * h.wy) * share * share * rise + part * (zy - h.zy);
  return mean;
}

// The arm's surface, continued into the junction: a plane by grade and tilt, and its crossfall, a function of n with
// kinks at the edges and at the reference line. Beyond the edges it stays level. The kinks are rounded by
// ahead^2 / width, which is nothing at the cut, to second order, and lets the crown melt away behind it.
FN JunctionHeight junction_height_add_cut(IN(JunctionHeight) h, IN(float) x, IN(float) y, IN(JunctionCut) c) {
  float width = c.left - c.right;
  float nx = (c.x0 - c.x1) / width;  // unit, to the left; the heading is (ny, -nx)
  float ny = (c.y0 - c.y1) / width;
  float ahead = (x - c.x1) * ny - (y - c.y1) * nx;
  float n = (x - c.x1) * nx + (y - c.y1) * ny + c.right;
  float beyond = n - clamp(n, c.right, c.left);
  float both = c.fall_left + c.fall_right;
  float cross = float(0.0);
  float cross_n = float(0.0);
  float cross_ahead = float(0.0);
  if (c.fall_left != 0.0 || c.fall_right != 0.0) {
    float soft = ahead * ahead / width;
    float dsoft = 2.0 * ahead / width;
    float hair = soft * soft + 1e-12;
    float at_right = sqrt((n - c.right) * (n - c.right) + hair);
    float at_middle = sqrt(n * n + hair);
    float at_left = sqrt((n - c.left) * (n - c.left) + hair);
    cross = 0.5 * (c.fall_right * (at_right + c.right) - both * at_middle + c.fall_left * (at_left - c.left));
    cross_n = 0.5 * (c.fall_right * (n - c.right) / at_right - both * n / at_middle +
                     c.fall_left * (n - c.left) / at_left);
    cross_ahead = 0.5 * soft * dsoft * (c.fall_right / at_right - both / at_middle + c.fall_left / at_left);
  }
  float z_ahead = c.grade + cross_ahead;
  float z_n = c.tilt + cross_n;
  return junction_height_add(h, width, ahead * ahead + beyond * beyond, 2.0 * (ahead * ny + beyond * nx),
                             2.0 * (beyond * ny - ahead * nx), c.z + c.grade * ahead + c.tilt * n + cross,
                             z_ahead * ny + z_n * nx, z_n * ny - z_ahead * nx);
}

// The tangent plane of the surface along the piece, at the chord parameter u = x clamped to [0, 1], plus the crossfall,
// which levels out within some 3.5 m. All is C1 over the whole plane: the distance is taken along y from the curve
// continued by its tangents, and what depends on u has no slope at its ends.
FN JunctionHeight junction_height_add_corner(IN(JunctionHeight) h, IN(float) x, IN(float) y, IN(JunctionCorner) c) {
  float inverse = 1.0 / c.chord;
  float px = ((x - c.x0) * c.cx + (y - c.y0) * c.cy) * inverse;
  float py = ((y - c.y0) * c.cx - (x - c.x0) * c.cy) * inverse;
  float u = clamp(px, float(0.0), float(1.0));
  float over = px - u;
  float du = over == 0.0 ? float(1.0) : float(0.0);
  float f = road_f(u, c.a, c.b);
  float df = road_df(u, c.a, c.b);
  float off = py - f - df * over;
  float s = c.chord * road_arc(u, c.a, c.b, c.arc * inverse, c.c0, c.c1);
  float ds = c.chord * road_darc(u, c.a, c.b, c.arc * inverse, c.c0, c.c1) * du;
  float t = u * u * (3.0 - 2.0 * u);
  float dt = 6.0 * u * (1.0 - u) * du;
  float along = mix(c.along0, c.along1, t);
  float across = mix(c.across0, c.across1, t);
  float z = road_cubic(s, c.z0, c.z1, c.z2, c.z3) + c.chord * (along * over + across * (py - f));
  float z_x = road_dcubic(s, c.z1, c.z2, c.z3) * ds +
              c.chord * (along * (1.0 - du) + (c.across1 - c.across0) * dt * (py - f) - across * df * du);
  float z_y = c.chord * across;
  if (c.fall0 != 0.0 || c.fall1 != 0.0) {
    float v = c.chord * off;
    float level = 3.5 / (3.5 + abs(v));
    float fall = mix(c.fall0, c.fall1, t);
    z += fall * v * level;
    z_x += (c.fall1 - c.fall0) * dt * v * level - fall * level * level * c.chord * df;
    z_y += fall * level * level * c.chord;
  }
  float d2_x = 2.0 * c.chord * (over - off * df);
  float d2_y = 2.0 * c.chord * off;
  return junction_height_add(h, c.arc, c.chord * c.chord * (off * off + over * over), d2_x * c.cx - d2_y * c.cy,
                             d2_x * c.cy + d2_y * c.cx, z, (z_x * c.cx - z_y * c.cy) * inverse,
                             (z_x * c.cy + z_y * c.cx) * inverse);
}

// Where a point lies against the boundary pieces so far.
struct JunctionSide {
  float corner;  // distance to the nearest corner curve
  float nx;      // unit normal of that curve there, to its left
  float ny;
  float cut;     // distance to the nearest cut
  bool inside;   // an odd number of pieces lies to the east: inside, once all pieces are added
};

FN JunctionSide junction_side_begin() {
  JunctionSide side;
  side.corner = float(1e6);
  side.nx = float(1.0);
  side.ny = float(0.0);
  side.cut = float(1e6);
  side.inside = false;
  return side;
}

// Whether the ray from (x, y) eastward crosses the straight from (x0, y0) to (x1, y1), on the left of which the point
// lies or not. Straights that share an end share its bits, so none is counted twice or missed.
FN bool junction_crosses(IN(float) y, IN(float) y0, IN(float) y1, IN(bool) on_left) {
  return (y0 > y) != (y1 > y) && (y1 > y0) == on_left;
}

// The same for a corner piece, (px, py) being the point in its chord frame: across the chord, or between it and its curve.
FN bool junction_corner_crosses(IN(float) y, IN(float) px, IN(float) py, IN(JunctionCorner) c) {
  bool on_left = py > 0.0;
  bool between = px > 0.0 && px < 1.0 && on_left != (py > road_f(px, c.a, c.b));
  return junction_crosses(y, c.y0, c.y1, on_left) != between;
}

FN JunctionSide junction_side_add_cut(IN(JunctionSide) side, IN(float) x, IN(float) y, IN(JunctionCut) c) {
  JunctionSide r = side;
  float width = c.left - c.right;
  float tx = (c.x1 - c.x0) / width;
  float ty = (c.y1 - c.y0) / width;
  float along = (x - c.x0) * tx + (y - c.y0) * ty;
  float across = (y - c.y0) * tx - (x - c.x0) * ty;
  float beyond = along - clamp(along, float(0.0), width);
  r.cut = min(r.cut, sqrt(across * across + beyond * beyond));
  if (junction_crosses(y, c.y0, c.y1, across > 0.0)) r.inside = !r.inside;
  return r;
}

// Inside the polygon of all chords, but for the points between a chord and its curve.
FN JunctionSide junction_side_add_corner(IN(JunctionSide) side, IN(float) x, IN(float) y, IN(JunctionCorner) c) {
  JunctionSide r = side;
  float px = ((x - c.x0) * c.cx + (y - c.y0) * c.cy) / c.chord;
  float py = ((y - c.y0) * c.cx - (x - c.x0) * c.cy) / c.chord;
  if (junction_corner_crosses(y, px, py, c)) r.inside = !r.inside;
  // |f| <= 4/27 (|a| + |b|): is the piece farther than another?
  float least = max(abs(py) - 0.15 * (abs(c.a) + abs(c.b)), max(-px, px - 1.0));
  if (least * c.chord > r.corner) return r;

  RoadCoord p = road_project(px, py, c.a, c.b);
  float df = road_df(p.u, c.a, c.b);
  float steep = sqrt(1.0 + df * df);
  // Beyond the piece's ends, and where the mapping is far from the nearest point, the distance to the point at u.
  float along = (px - p.u + (py - road_f(p.u, c.a, c.b)) * df) / steep;
  bool mapped = p.u > 0.0 && p.u < 1.0 && abs(along) < 0.02;
  float d = c.chord * (mapped ? abs(p.v) : sqrt(p.v * p.v + along * along));
  if (d < r.corner) {
    r.corner = d;
    r.nx = -(c.cx * df + c.cy) / steep;
    r.ny = (c.cx - c.cy * df) / steep;
  }
  return r;
}

// Signed distance to the boundary, positive inside.
FN float junction_distance(IN(JunctionSide) side) {
  float d = min(side.corner, side.cut);
  return side.inside ? d : -d;
}

// Signed distance to the corner curves alone, for an edge that is antialiased there and open at the cuts, where a road
// goes on: the area then reaches a millimetre into the arms, so rounding leaves no crack.
FN float junction_open_distance(IN(JunctionSide) side) {
  if (side.inside || side.cut < 1e-3) return side.corner;
  return side.cut <= side.corner * 1.00001 ? float(-1e6) : -side.corner;
}
