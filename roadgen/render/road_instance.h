// A network as the GPU sees it: tiles of segments, and the tables that segments refer to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/road/network.h"

namespace roadgen {

// A double as the sum of two floats, exact to 48 bits: coordinates 1e7 m from the origin keep 1e-7 m.
struct SplitPosition {
  glm::vec3 high, low;
};
SplitPosition split(glm::dvec3 p);

// One segment, an instance's attributes in the layout that shaders/road.vert declares; 124 bytes.
struct RoadInstance {
  glm::vec3 start;           // start anchor relative to its tile, ENU, m
  std::uint32_t tile;        // index of the tile
  glm::vec4 shape;           // chord x, y (m), slopes a, b
  glm::vec4 arc;             // arc length (m), c0, c1, s at the start (m)
  glm::vec4 height;          // z1, z2, z3, what s at the start is more than its float
  glm::vec4 superelevation;  // cubic in s, rad
  glm::vec4 box;             // y low, y high (chord frame), z low, z high (m above the plane of the chord)
  std::uint32_t road;        // index of the road
  std::uint32_t section;     // where its section begins in SectionTable::data
  std::uint32_t paint;       // first of its paint * 256 + how many
  std::uint32_t flags;       // RoadFlags
  float section_s;           // s at the start from the section's start, m
  std::uint32_t crossfall_left, crossfall_right;  // each at the start and at the end, as two halves
};
static_assert(sizeof(RoadInstance) == 124);

enum RoadFlags : std::uint32_t { kOpenStart = 1, kOpenEnd = 2 };

// The noise repeats along s by NOISE_PERIOD of shaders/lib/noise.glsl.
inline constexpr double kNoisePeriod_m = 4096;

// What segments share. Four floats each.
using Table = std::vector<glm::vec4>;

// How segments are drawn: planar as the paper's single quad; with relief ray-cast within a box; detailed likewise, with
// raised strips or paint.
enum RoadKind { kPlanar, kRelief, kDetailed };
inline constexpr std::size_t kRoadKinds = 3;

// Segments that lie together; their starts are floats relative to origin_m.
struct RoadTile {
  glm::dvec3 origin_m{0, 0, 0};
  Bounds bounds;  // of all footprints and lanes' heights
  struct Range {
    std::uint32_t first = 0, count = 0;
  };
  std::array<Range, kRoadKinds> ranges;  // of RoadScene::instances
};
inline constexpr double kTileSize_m = 256;

struct RoadScene {
  std::vector<RoadTile> tiles;
  std::array<std::vector<RoadInstance>, kRoadKinds> instances;  // by tile, in a tile from low to high
  Table sections;                                               // layout: shaders/sections.glsl
  Table paint;                                                  // likewise
};
RoadScene road_scene(const Network& network);

// What a renderer holds of the roads, and what the last picture or set of channels took.
struct RoadStatistics {
  std::size_t segments = 0, tiles = 0;
  std::size_t instance_bytes = 0;  // in the CPU's memory
  std::size_t pool_bytes = 0;      // on the GPU: instances of the tiles seen last
  std::size_t table_bytes = 0;     // on the GPU: origins of tiles, sections, paint
  std::size_t drawn_segments = 0, drawn_tiles = 0;
  std::size_t batches = 0;         // indirect draws
  std::size_t uploaded_bytes = 0;  // into the pool
};

// A segment whose surface departs from a plane by at most this, and whose lanes all lie on it, is drawn as a quad.
inline constexpr double kPlanarTolerance_m = 1e-3;

// Bounds of the height of the surface over the footprint above the plane through the start anchor that rises along the
// chord to the end anchor. Proven: by the range of the cubic's deviation along s, the lean of the lines u = const, and
// the greatest slope across.
Cubic::Range planar_deviation_m(const Segment& segment);

}  // namespace roadgen
