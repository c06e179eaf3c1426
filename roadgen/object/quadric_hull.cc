#include "roadgen/object/quadric_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// Places this far outside of the box or off the quadric count as within and on: more are tried then, never fewer.
constexpr double kTolerance = 1e-6;
// Planes that cut less than this off the polyhedron so far are not worth their triangles: measured, on a software rasterizer,
// whose pixels cost more along triangles' edges. With 0.03 there are 0.24 rejected pixels per accepted one, with 0.3 0.29, and
// frames of quadrics 12 pixels wide take 10 % less time.
constexpr double kLeastCut = 0.3;

template <int N>
using Matrix = std::array<std::array<double, N>, N>;

template <int N>
double minor_of(const Matrix<N>& m, int row, int column);

template <int N>
double determinant(const Matrix<N>& m) {
  if constexpr (N == 1) {
    return m[0][0];
  } else {
    double sum = 0;
    for (int i = 0; i < N; ++i) sum += (i % 2 ? -1 : 1) * m[0][static_cast<std::size_t>(i)] * minor_of<N>(m, 0, i);
    return sum;
  }
}

template <int N>
double minor_of(const Matrix<N>& m, int row, int column) {
  Matrix<N - 1> rest;
  for (int i = 0; i < N - 1; ++i) {
    for (int k = 0; k < N - 1; ++k) {
      rest[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
          m[static_cast<std::size_t>(i + (i >= row))][static_cast<std::size_t>(k + (k >= column))];
    }
  }
  return determinant<N - 1>(rest);
}

// a x^2 + 2 b x + c = 0, where a double root that digits have lost counts.
struct Roots {
  int count = 0;
  double x[2];
};
Roots roots(double a, double b, double c) {
  Roots r;
  double square = b * b - a * c;
  if (square < -1e-9 * (b * b + std::abs(a * c))) return r;
  square = std::sqrt(std::max(square, 0.0));
  const double q = b > 0 ? -b - square : square - b;
  if (std::abs(a) > 1e-14 * std::abs(q)) r.x[r.count++] = q / a;
  if (q != 0) r.x[r.count++] = c / q;
  return r;
}

// A conic or quadric x^T M x = 0, x = (p, 1), as its tangents: the line or plane g p = s touches it where l^T D l = 0 with
// D the adjugate of M and l = (g, -s), at the place D l. This also holds of paraboloids, whose M_ij alone are singular.
// Of cones and crossing lines D l vanishes there, but they end in their centre.
template <int N>
class Tangents {
 public:
  explicit Tangents(const Matrix<N>& m) {
    for (int i = 0; i < N; ++i) {
      for (int k = 0; k < N; ++k) {
        dual_[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] = ((i + k) % 2 ? -1 : 1) * minor_of<N>(m, k, i);
      }
    }
  }
  // Calls visit(place, g p) for places within [-1, 1] that have such a tangent, at most two.
  template <class Visit>
  void touch(const std::array<double, N - 1>& g, Visit visit) const {
    double b = 0, c = 0;
    for (std::size_t i = 0; i < N - 1; ++i) {
      b -= dual_[N - 1][i] * g[i];
      for (std::size_t k = 0; k < N - 1; ++k) c += dual_[i][k] * g[i] * g[k];
    }
    const Roots r = roots(dual_[N - 1][N - 1], b, c);
    for (int i = 0; i < r.count; ++i) {
      std::array<double, N> place{};
      for (std::size_t k = 0; k < N; ++k) {
        for (std::size_t j = 0; j < N - 1; ++j) place[k] += dual_[k][j] * g[j];
        place[k] -= dual_[k][N - 1] * r.x[i];
      }
      if (within(place)) visit(place, r.x[i]);
    }
  }
  double reach(const std::array<double, N - 1>& g) const {
    double greatest = -std::numeric_limits<double>::infinity();
    touch(g, [&](const auto&, double s) { greatest = std::max(greatest, s); });
    return greatest;
  }
  // The centre, of w = 0 where there is none.
  std::array<double, N> centre() const { return dual_[N - 1]; }
  static bool within(const std::array<double, N>& place) {
    const double most = std::abs(place[N - 1]) * (1 + kTolerance);
    return most > 0 && std::all_of(place.begin(), place.end() - 1, [&](double x) { return std::abs(x) <= most; });
  }

 private:
  Matrix<N> dual_;
};

// How far the quadric, or its solid, reaches within the box: the greatest g p is attained where a plane of normal g touches it,
// within the box or within one of its faces, on an edge of the box, or at a corner.
class QuadricReach {
 public:
  explicit QuadricReach(const ObjectLib::ObjectShape& s) : shape_(s), q_(matrix(s)), inside_(q_) {
    for (std::size_t face = 0; face < 6; ++face) add_face(face / 2, face % 2 ? 1 : -1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 4; ++k) add_edge(axis, k & 1 ? 1 : -1, k & 2 ? 1 : -1);
    }
    add_centre(inside_.centre());
    if ((s.flags & OBJECT_SOLID) == 0) return;
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      if (ObjectLib::quadric_value(corner, s) <= kTolerance) places_.push_back(corner);
    }
  }
  double operator()(glm::dvec3 g) const {
    double greatest = inside_.reach({g.x, g.y, g.z});
    for (const Face& f : faces_) {
      greatest = std::max(
          greatest, g[static_cast<int>(f.axis)] * f.at + f.tangents.reach({g[(static_cast<int>(f.axis) + 1) % 3],
                                                                           g[(static_cast<int>(f.axis) + 2) % 3]}));
    }
    for (const glm::dvec3& p : places_) greatest = std::max(greatest, glm::dot(g, p));
    return greatest;
  }

 private:
  struct Face {
    std::size_t axis;
    double at;
    Tangents<3> tangents;
  };

  static Matrix<4> matrix(const ObjectLib::ObjectShape& s) {
    if ((s.flags & OBJECT_PLANES) != 0) {
      const double one[] = {s.p0, s.p1, s.p2, s.p3}, two[] = {s.p4, s.p5, s.p6, s.p7};
      Matrix<4> m;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 4; ++k) m[i][k] = 0.5 * (one[i] * two[k] + one[k] * two[i]);
      }
      return m;
    }
    return {{{s.p0, 0.5 * s.p3, 0.5 * s.p4, 0.5 * s.p6},
             {0.5 * s.p3, s.p1, 0.5 * s.p5, 0.5 * s.p7},
             {0.5 * s.p4, 0.5 * s.p5, s.p2, 0.5 * s.p8},
             {0.5 * s.p6, 0.5 * s.p7, 0.5 * s.p8, s.p9}}};
  }

  void add_face(std::size_t axis, double at) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3, free[] = {u, v, 3};
    Matrix<3> m;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) m[i][k] = q_[free[i]][free[k]];
    }
    for (std::size_t i = 0; i < 2; ++i) {
      m[i][2] += q_[free[i]][axis] * at;
      m[2][i] = m[i][2];
    }
    m[2][2] += (2 * q_[axis][3] + q_[axis][axis] * at) * at;
    faces_.push_back({axis, at, Tangents<3>(m)});
    const auto in_space = [&](const std::array<double, 3>& p) {
      std::array<double, 4> place{};
      place[axis] = at * p[2], place[u] = p[0], place[v] = p[1], place[3] = p[2];
      return place;
    };
    add_centre(in_space(faces_.back().tangents.centre()));
    // Any of a solid's end in the face, for planes along it.
    faces_.back().tangents.touch({1, 0}, [&](const auto& p, double) { places_.push_back(in_box(in_space(p))); });
  }

  static glm::dvec3 in_box(const std::array<double, 4>& place) {
    return glm::dvec3(place[0], place[1], place[2]) / place[3];
  }

  // Where the quadric ends in its centre, or crosses itself there.
  void add_centre(const std::array<double, 4>& place) {
    if (!Tangents<4>::within(place)) return;
    const glm::dvec3 p = in_box(place);
    if (std::abs(ObjectLib::quadric_value(p, shape_)) <= kTolerance) places_.push_back(p);
  }

  void add_edge(std::size_t axis, double at_u, double at_v) {
    const auto add = [&](double x) {
      if (!(std::abs(x) <= 1 + kTolerance)) return;
      glm::dvec3 p;
      p[static_cast<int>(axis)] = x, p[(static_cast<int>(axis) + 1) % 3] = at_u,
      p[(static_cast<int>(axis) + 2) % 3] = at_v;
      places_.push_back(p);
    };
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    if ((shape_.flags & OBJECT_PLANES) != 0) {
      // Each plane by itself: of a double one the product's roots are not told from none.
      const double planes[2][4] = {{shape_.p0, shape_.p1, shape_.p2, shape_.p3},
                                   {shape_.p4, shape_.p5, shape_.p6, shape_.p7}};
      for (const auto& n : planes) {
        if (n[axis] != 0) add(-(n[u] * at_u + n[v] * at_v + n[3]) / n[axis]);
      }
      return;
    }
    const double b = q_[axis][3] + q_[axis][u] * at_u + q_[axis][v] * at_v;
    const double c = q_[3][3] + at_u * (q_[u][u] * at_u + 2 * q_[u][3]) + at_v * (q_[v][v] * at_v + 2 * q_[v][3]) +
                     2 * q_[u][v] * at_u * at_v;
    const Roots r = roots(q_[axis][axis], b, c);
    for (int i = 0; i < r.count; ++i) add(r.x[i]);
  }

  ObjectLib::ObjectShape shape_;
  Matrix<4> q_;
  Tangents<4> inside_;
  std::vector<Face> faces_;
  std::vector<glm::dvec3> places_;
};

// A polyhedron as its faces' corners, counter-clockwise from outside.
class Polyhedron {
 public:
  Polyhedron() {
    for (int i = 0; i < 8; ++i) corners_.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    faces_ = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  }
  double reach(glm::dvec3 g) const {
    double greatest = -std::numeric_limits<double>::infinity();
    for (const auto& face : faces_) {
      for (const std::size_t i : face) greatest = std::max(greatest, glm::dot(g, corners_[i]));
    }
    return greatest;
  }
  // Leaves what has g p <= s. Requires: something is left.
  void cut(glm::dvec3 g, double s) {
    std::vector<std::size_t> rim;
    std::vector<std::vector<std::size_t>> kept;
    for (const auto& face : faces_) {
      std::vector<std::size_t> rest;
      for (std::size_t i = 0; i < face.size(); ++i) {
        const std::size_t a = face[i], b = face[(i + 1) % face.size()];
        const double at_a = glm::dot(g, corners_[a]) - s, at_b = glm::dot(g, corners_[b]) - s;
        if (at_a <= 0) rest.push_back(a);
        if ((at_a <= 0) == (at_b <= 0)) continue;
        // From one end, whichever way the face goes along the edge: the same to the bit.
        const std::size_t low = std::min(a, b), high = std::max(a, b);
        const double from = low == a ? at_a : at_b, to = low == a ? at_b : at_a;
        rest.push_back(corner(corners_[low] + (corners_[high] - corners_[low]) * (from / (from - to))));
        rim.push_back(rest.back());
      }
      rest.erase(std::unique(rest.begin(), rest.end()), rest.end());
      while (rest.size() > 1 && rest.front() == rest.back()) rest.pop_back();
      if (rest.size() >= 3) kept.push_back(std::move(rest));
    }
    faces_ = std::move(kept);
    close(g, std::move(rim));
  }
  ConvexHull hull() const {
    ConvexHull h;
    std::vector<std::size_t> number(corners_.size(), corners_.size());
    const auto add = [&](std::size_t i) {
      if (number[i] == corners_.size()) {
        number[i] = h.corners.size();
        h.corners.push_back(corners_[i]);
      }
      return static_cast<std::uint16_t>(number[i]);
    };
    for (const auto& face : faces_) {
      for (std::size_t i = 2; i < face.size(); ++i)
        h.triangles.push_back({add(face[0]), add(face[i - 1]), add(face[i])});
    }
    return h;
  }

 private:
  // Places as near as this are one.
  static constexpr double kSame = 1e-9;

  std::size_t corner(glm::dvec3 p) {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const glm::dvec3 d = glm::abs(corners_[i] - p);
      if (std::max({d.x, d.y, d.z}) < kSame) return i;
    }
    corners_.push_back(p);
    return corners_.size() - 1;
  }

  // The face where it was cut, its corners in their order around the plane's normal.
  void close(glm::dvec3 g, std::vector<std::size_t> rim) {
    std::sort(rim.begin(), rim.end());
    rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
    if (rim.size() < 3) return;
    glm::dvec3 middle(0);
    for (const std::size_t i : rim) middle += corners_[i] / static_cast<double>(rim.size());
    const glm::dvec3 n = glm::normalize(g), other = std::abs(n.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(other, n)), y = glm::cross(n, x);
    const auto angle = [&](std::size_t i) {
      return std::atan2(glm::dot(y, corners_[i] - middle), glm::dot(x, corners_[i] - middle));
    };
    std::sort(rim.begin(), rim.end(), [&](std::size_t a, std::size_t b) { return angle(a) < angle(b); });
    faces_.push_back(std::move(rim));
  }

  std::vector<glm::dvec3> corners_;
  std::vector<std::vector<std::size_t>> faces_;
};

std::vector<glm::dvec3> directions(const ObjectLib::ObjectShape& s) {
  std::vector<glm::dvec3> result;
  if ((s.flags & OBJECT_PLANES) != 0) {
    for (const glm::dvec3 n : {glm::dvec3(s.p0, s.p1, s.p2), glm::dvec3(s.p4, s.p5, s.p6)}) {
      result.push_back(n), result.push_back(-n);
    }
  } else {
    const QuadricAxes axes = quadric_axes({s.p0, s.p1, s.p2, s.p3, s.p4, s.p5, s.p6, s.p7, s.p8, s.p9});
    for (const glm::dvec3& v : axes.vectors) result.push_back(v), result.push_back(-v);
    // Of a plane its own.
    const glm::dvec3 slope(s.p6, s.p7, s.p8);
    if (glm::length(slope) > 0) result.push_back(slope), result.push_back(-slope);
  }
  for (const int ends : {1, 2, 3}) {
    for (int i = 0; i < 27; ++i) {
      const glm::dvec3 d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (std::abs(d.x) + std::abs(d.y) + std::abs(d.z) == ends) result.push_back(d);
    }
  }
  for (glm::dvec3& d : result) d = glm::normalize(d);
  return result;
}

}  // namespace

ConvexHull quadric_hull(const ObjectLib::ObjectShape& shape) {
  const QuadricReach reach(shape);
  struct Plane {
    glm::dvec3 g;
    double s;
  };
  std::vector<Plane> planes;
  for (const glm::dvec3& g : directions(shape)) planes.push_back({g, reach(g) + kHullRoom});
  Polyhedron polyhedron;
  if (!std::isfinite(planes[0].s)) return polyhedron.hull();
  // The deepest cut first: what comes later may have nothing left to cut.
  for (;;) {
    double deepest = kLeastCut;
    const Plane* best = nullptr;
    for (const Plane& plane : planes) {
      const double depth = polyhedron.reach(plane.g) - plane.s;
      if (depth > deepest) deepest = depth, best = &plane;
    }
    if (!best) return polyhedron.hull();
    polyhedron.cut(best->g, best->s);
  }
}

}  // namespace roadgen
