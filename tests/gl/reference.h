// The reference picture: a road scene by brute force in double precision, against which the GPU's is measured.
//
// Many rays per pixel. Each walks along its segment's surroundings until it passes from above the lanes to below them,
// which bisection pins down; the hit gets the material, mark or paint at that very point. There is no filter and no
// iteration of the pixel shader's in it: (u, v) is the exact projection, lanes are looked up by plain comparisons, and
// only what defines a look (albedo, light, haze, tone) is the shader library's, evaluated with a sample's footprint.
//
// Not covered: lanes below the road surface or rising across their width, and views into the open end of a raised road.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/render/camera.h"
#include "roadgen/render/renderer.h"
#include "roadgen/road/network.h"

namespace roadgen::test {

// Corners of the colour cube for what a sample shows, so that the colours of a mixture tell the parts: if two kinds share
// a pixel, the greatest difference of a channel is the difference of the parts.
glm::dvec3 flat_color(Material material);
inline constexpr glm::dvec3 kFlatPaint{1, 1, 1};
inline constexpr glm::dvec3 kFlatBackground{0, 0, 0};

struct ReferencePixel {
  glm::dvec3 color{0};    // linear, mean of the samples' tone-mapped colours
  glm::dvec3 flat{0};     // mean of their flat colours
  double background = 0;  // part of the samples that hit no road
  bool mixed = false;     // samples of more than one kind: material, paint, background
  bool traced = false;    // false: not asked for
};

struct ReferenceOptions {
  int width = 320, height = 240;
  // Their squares are the numbers of rays per pixel: 64, and more where kinds meet, since an edge through n^2 samples is
  // off by up to 1 / 2n.
  int grid = 8, edge_grid = 24;
  Lighting lighting = {};
  std::function<bool(int x, int y)> wanted = [](int, int) { return true; };  // which pixels; must be thread-safe
};

// Rows from the top. Cost: about 2 us per ray and thread; two threads.
std::vector<ReferencePixel> reference_picture(const Network& network, const Camera& camera,
                                              const ReferenceOptions& options);

// How far a point is from the road's lanes, m: above or below the strip there, or horizontally from a vertical face
// whose height it lies at, whichever is nearer. Infinity beside all roads.
double distance_from_lanes(const Network& network, glm::dvec3 point_m);

// 8-bit sRGB of a linear value in [0, 1], and back.
std::uint8_t srgb_from_linear(double linear);
double linear_from_srgb(std::uint8_t srgb);

}  // namespace roadgen::test
