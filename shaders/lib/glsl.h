// The shader library as C++: every file of shaders/lib/*.glsl, compiled for a scalar type of choice.
//
// The same text is the GLSL library of the pixel shaders, so a formula exists once. In C++ the text stands inside the
// class template Library<Real>, where `float` means Real, FN means `static`, IN(T) a value and OUT(T) a reference:
//
//   using Lib = roadgen::glsl::Library<double>;
//   Lib::RoadCoord c = Lib::road_project(x, y, a, b);
//
// Real may be double (the truth that everything is tested against), Float32 (rounds after every operation, as GLSL's
// float does), or an automatic-differentiation scalar such as ceres::Jet (functions of scalars only).
//
// Rules for shaders/lib/*.glsl: pure functions, no uniforms, samplers, built-in variables or swizzles; parameters by
// IN/OUT; a literal that stands alone (returned, assigned, or passed to a function) is written float(0.5), since a
// bare 0.5 is a double in C++.
//
// Model: the dual-compiled shader functions of E. Bruneton's precomputed atmospheric scattering.
#pragma once

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace roadgen::glsl {

// IEEE single precision that never widens: double literals are rounded first, then every operation rounds to float.
class Float32 {
 public:
  Float32() = default;
  constexpr Float32(double x) : value_(static_cast<float>(x)) {}  // implicit: literals in shader text are doubles
  constexpr Float32(float x) : value_(x) {}
  constexpr Float32(int x) : value_(static_cast<float>(x)) {}
  constexpr explicit operator double() const { return value_; }
  constexpr explicit operator float() const { return value_; }
  constexpr explicit operator int() const { return static_cast<int>(value_); }

  constexpr Float32& operator+=(Float32 b) { return *this = *this + b; }
  constexpr Float32& operator-=(Float32 b) { return *this = *this - b; }
  constexpr Float32& operator*=(Float32 b) { return *this = *this * b; }
  constexpr Float32& operator/=(Float32 b) { return *this = *this / b; }
  friend constexpr Float32 operator-(Float32 a) { return Float32(-a.value_); }
  friend constexpr Float32 operator+(Float32 a, Float32 b) { return Float32(a.value_ + b.value_); }
  friend constexpr Float32 operator-(Float32 a, Float32 b) { return Float32(a.value_ - b.value_); }
  friend constexpr Float32 operator*(Float32 a, Float32 b) { return Float32(a.value_ * b.value_); }
  friend constexpr Float32 operator/(Float32 a, Float32 b) { return Float32(a.value_ / b.value_); }
  friend constexpr bool operator<(Float32 a, Float32 b) { return a.value_ < b.value_; }
  friend constexpr bool operator>(Float32 a, Float32 b) { return a.value_ > b.value_; }
  friend constexpr bool operator<=(Float32 a, Float32 b) { return a.value_ <= b.value_; }
  friend constexpr bool operator>=(Float32 a, Float32 b) { return a.value_ >= b.value_; }
  friend constexpr bool operator==(Float32 a, Float32 b) { return a.value_ == b.value_; }

  friend Float32 sqrt(Float32 x) { return Float32(std::sqrt(x.value_)); }
  friend Float32 sin(Float32 x) { return Float32(std::sin(x.value_)); }
  friend Float32 cos(Float32 x) { return Float32(std::cos(x.value_)); }
  friend Float32 acos(Float32 x) { return Float32(std::acos(x.value_)); }
  friend Float32 atan(Float32 y, Float32 x) { return Float32(std::atan2(y.value_, x.value_)); }
  friend Float32 exp(Float32 x) { return Float32(std::exp(x.value_)); }
  friend Float32 pow(Float32 x, Float32 y) { return Float32(std::pow(x.value_, y.value_)); }
  friend Float32 abs(Float32 x) { return Float32(std::abs(x.value_)); }
  friend Float32 floor(Float32 x) { return Float32(std::floor(x.value_)); }

 private:
  float value_;
};

// GLSL's built-in functions by which the library is written. Found by argument-dependent lookup for class scalars.
using std::abs;
using std::acos;
using std::cos;
using std::exp;
using std::floor;
using std::pow;
using std::sin;
using std::sqrt;
inline double atan(double y, double x) { return std::atan2(y, x); }
template <class T>
T min(const T& a, const T& b) { return b < a ? b : a; }
template <class T>
T max(const T& a, const T& b) { return a < b ? b : a; }
template <class T>
T clamp(const T& x, const T& low, const T& high) { return min(max(x, low), high); }
template <class T>
T mix(const T& a, const T& b, const T& t) { return a * (T(1.0) - t) + b * t; }
template <class T>
glm::vec<3, T> mix(const glm::vec<3, T>& a, const glm::vec<3, T>& b, const T& t) { return a * (T(1.0) - t) + b * t; }
template <class T>
T fract(const T& x) { return x - floor(x); }
template <class T>
T sign(const T& x) { return x < T(0.0) ? T(-1.0) : (T(0.0) < x ? T(1.0) : T(0.0)); }
template <class T>
T smoothstep(const T& low, const T& high, const T& x) {
  const T t = clamp((x - low) / (high - low), T(0.0), T(1.0));
  return t * t * (T(3.0) - T(2.0) * t);
}
template <class T>
T dot(const glm::vec<2, T>& a, const glm::vec<2, T>& b) { return a.x * b.x + a.y * b.y; }
template <class T>
T dot(const glm::vec<3, T>& a, const glm::vec<3, T>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
// For each size: GLM's own, which refuse class scalars, would be preferred to a template of any vector.
template <class T>
T length(const glm::vec<2, T>& v) { return sqrt(dot(v, v)); }
template <class T>
T length(const glm::vec<3, T>& v) { return sqrt(dot(v, v)); }
template <class T>
glm::vec<2, T> normalize(const glm::vec<2, T>& v) { return v * (T(1.0) / length(v)); }
template <class T>
glm::vec<3, T> normalize(const glm::vec<3, T>& v) { return v * (T(1.0) / length(v)); }

// Functions of one kind take the same parameters, whether they need them or not.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
template <class Real>
struct Library {
  using vec2 = glm::vec<2, Real>;
  using vec3 = glm::vec<3, Real>;
  using uint = unsigned int;
#define float Real
#define FN static
#define IN(T) T
#define OUT(T) T&
#include "shaders/lib/road.glsl"
#include "shaders/lib/surface.glsl"
#include "shaders/lib/marking.glsl"
#include "shaders/lib/noise.glsl"
#include "shaders/lib/sky.glsl"
#include "shaders/lib/light.glsl"
#include "shaders/lib/ground.glsl"
#include "shaders/lib/material.glsl"
#include "shaders/lib/junction.glsl"
#include "shaders/lib/sweep.glsl"
#include "shaders/lib/object.glsl"
#include "shaders/lib/sphere.glsl"
#include "shaders/lib/quadric.glsl"
#include "shaders/lib/cone.glsl"
#include "shaders/lib/polyhedron.glsl"
#include "shaders/lib/torus.glsl"
#include "shaders/lib/planar.glsl"
#undef OUT
#undef IN
#undef FN
#undef float
};
#pragma GCC diagnostic pop

}  // namespace roadgen::glsl
