// The scene of the paper's Fig. 13 and its copies side by side: a road of 97 segments on a ground of about 2,868
// triangles, made by formula. Source: Loviscach 2005, section 5.
#pragma once

#include <span>
#include <vector>

#include "roadgen/render/camera.h"
#include "roadgen/road/network.h"
#include "terrain/terrain.h"

namespace roadgen::bench {

inline constexpr std::size_t kBaseSegments = 97;
inline constexpr double kSide_m = 768;   // of the square that the base scene fills, its low corner at the origin
inline constexpr int kGroundCells = 38;  // along each side, two triangles each

struct BaseScene {
  Road road;  // closed
  TerrainMesh ground;
};

// hills_m: amplitude of the ground's waves; 0 makes a level road, each segment of which lies in a plane.
// Errors: the curve does not come out at kBaseSegments.
Result<BaseScene> base_scene(double hills_m);

// Low corners of n x n copies, the first's at the origin and the others around it. Requires: n odd.
std::vector<glm::dvec3> copy_origins(int n);
Network copies_of(const Road& road, std::span<const glm::dvec3> origins);
std::vector<TerrainMesh> copies_of(const TerrainMesh& ground, std::span<const glm::dvec3> origins);

// Views from the base scene's road: a driver's and from above it, by turns. 45 degrees, to 1.5 sides away.
std::vector<Camera> views(const BaseScene& scene, int count);

}  // namespace roadgen::bench
