// Draws a network and its ground: picture, depth, labels, normals and road coordinates of one camera.
//
//   auto context = Context::create({.kind = ContextKind::kOsmesa});
//   auto renderer = Renderer::create(**context);
//   renderer->load_roads(network);
//   Result<Frame> frame = renderer->render(camera, {.width = 1280, .height = 720});
//
// Every road pixel is computed by the road function (shaders/lib/road.glsl), not from a tessellation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "roadgen/object/object.h"
#include "roadgen/render/camera.h"
#include "roadgen/render/context.h"
#include "roadgen/render/image.h"
#include "roadgen/render/road_instance.h"
#include "roadgen/road/network.h"
#include "terrain/detail.h"
#include "terrain/ground_source.h"
#include "terrain/terrain.h"

namespace roadgen {

// What to read back; bits of FrameOptions::channels.
enum Channel : unsigned {
  kColor = 1,
  kDepth = 2,
  kLabel = 4,
  kInstance = 8,
  kNormal = 16,
  kRoad = 32,
  kAllChannels = 63,
};

// Values of the label channel. Structures are the sweeps along roads: tunnels, guard rails, pipes, cables, and their posts.
enum class Label : std::uint32_t {
  kNone = 0,
  kGround = 1,
  kCarriageway = 2,
  kMarking = 3,
  kStructure = 4,
  kObject = 5
};

struct FrameOptions {
  int width = 1280, height = 720;  // pixels, in [1, 16384]
  unsigned channels = kColor;
  int samples = 4;  // of the picture: 1 or 4. Data channels are taken at pixel centres
};

// A channel that was not asked for has no pixels.
struct Frame {
  Image8 color;                // RGBA
  ImageF depth_m;              // along the view axis, +inf where nothing is
  Image<std::uint32_t> label;  // Label
  // 1 + index of the road, also of its structures; 1 + number of roads + index of the junction; 1 + number of roads and
  // junctions + number of the object (ObjectScene::instances); 0 elsewhere. Exact below 2^24.
  Image<std::uint32_t> instance;
  ImageF normal;  // 3 channels: unit, ENU; 0 where nothing is
  // 4 channels: index of the road, s (m), t (m), lane; on a junction -2 - its index, x and y (m, ENU) from its centre
  // (JunctionSurface::center_m), 0; elsewhere index -1.
  ImageF road;
};

// How a renderer goes about its work; the picture is the same but for what least_contribution states.
struct RendererOptions {
  // Of instance memory on the GPU; tables of the whole network come to it, see RoadStatistics. Where one frame needs
  // more, it is drawn in batches. Default: 256 MiB, 2 million segments. At least 31 KiB.
  std::size_t gpu_budget_bytes = std::size_t{256} << 20;
  // Far roads near the eye's horizon are left out of the picture (never of the data channels) where what that changes is
  // at most this part of full brightness even if roads covered all the ground there; TileIndex::contribution has the
  // derivation. 0: none is left out. In [0, 1]. Default: four steps of 8 bits, of which real roads take a fraction
  double least_contribution = 4.0 / 255;
  // How far the ground's mesh may be off in the picture, in height, seen from the eye straight on: its triangles are joined
  // within that, never so that one comes through a road (terrain/detail.h). Data channels show all of it, so that depth
  // and contact agree. 0: the picture too. >= 0. Default: half a pixel
  double ground_error_pixels = 0.5;
  // Of the ground's vertices and indices on the GPU, and of what is held of a ground that lies in a file. Where one frame
  // needs more, it is drawn in batches. Default: 256 MiB, 5 million triangles. At least 64 KiB
  std::size_t ground_budget_bytes = std::size_t{256} << 20;
  // False: roads outside of the view and ground behind nearer ground are drawn too, for comparison.
  bool cull = true;
};

// How objects are drawn; what is seen is the same.
struct ObjectOptions {
  // Spheres and ellipsoids by the rectangle on the screen that they touch; else by a polygon around the circle in which
  // the eye sees them, which wastes fewer pixels.
  bool rectangle = false;
  // Corners of that polygon, and of those around discs; two more around cylinders, twice as many around tori: 3 to 32; or 0:
  // 8, and for spheres of sets, which cost little a pixel, by their size on the screen: 3, 4 or 8. See README, objects.
  int polygon = 0;
  // Acceptance where the rasterizer interpolates the plane of a flat shape, or the circle of a sphere (the paper's texture
  // space), in place of the ray's own place in 3D.
  bool texture_space = false;
  // Spheres of sets that nothing is seen of are found on the CPU and not drawn; about 50 ns a sphere, which a GPU may
  // spend better itself.
  bool occlusion = true;
  // The sun's shadows of objects on roads, ground and each other.
  bool shadows = true;
};

struct ObjectStatistics {
  std::size_t objects = 0, spheres = 0;              // in the scene
  std::size_t drawn_objects = 0, drawn_spheres = 0;  // in the last frame
};

struct Lighting {
  double sun_azimuth_deg = 215;   // counter-clockwise from east
  double sun_elevation_deg = 38;  // in (0, 90]
  double haze_range_m = 9000;     // e-folding length of the view through air, > 0
};

// What the ground is made of where a texture may show it.
enum class GroundMaterial { kGrass, kRock, kGravel };

class Renderer {
 public:
  // Reads the programs' files; each program is compiled when a frame first needs it. The context must outlive the renderer.
  // Errors: kIo, kShader with file and line; kUsage: an option out of its range.
  static Result<Renderer> create(Context& context, const RendererOptions& options = {});
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  // Replaces what is drawn. Cost: O(n log n), n segments; kBytesPerSegment for each, in the CPU's memory and, once seen,
  // within the budget on the GPU.
  // Errors: kData with the road, where a number is not finite, or a segment has no length or no lane section; kContext
  // where the context cannot be made current.
  Status load_roads(const Network& network);
  Status load_ground(std::span<const TerrainMesh> tiles);
  // The same without a copy, as Terrain::ground() gives it; it is read as it is seen. Errors: kContext; later, where a frame
  // is drawn, the source's.
  Status load_ground(std::shared_ptr<const GroundSource> ground);
  // Replaces the objects; on an error they are as they were. Cost: O(n log n), n objects and spheres.
  // Errors: kData with the object, for the first that check() finds or where the GPU has no room; kUsage: an option out of
  // its range; kShader.
  Status load_objects(const ObjectScene& scene, const ObjectOptions& options = {});
  ObjectStatistics object_statistics() const;
  // What objects mirror, are lit by beside the sun, and let through; and the picture's sky: an image as read_panorama gives
  // it (roadgen/render/panorama.h), or by default the procedural sky. Roads and ground keep the light of that.
  // Errors: kData: not three channels, or no pixels; kShader.
  Status load_environment(const ImageF& panorama);
  // A picture, sRGB, that repeats every 4 m and, turned, every 12.8 m, in place of the material's own colours; for all
  // ground, also of later loads. Errors: kData: no pixels; kContext.
  Status set_ground_texture(GroundMaterial material, const Image8& picture);
  void set_lighting(const Lighting& lighting);
  static constexpr int kBytesPerSegment = 124;
  RoadStatistics road_statistics() const;
  GroundStatistics ground_statistics() const;

  // Draws and reads back; waits for all ground that the picture shows. Errors: kUsage for sizes or a camera out of range,
  // kContext where the GPU refuses, kShader.
  Result<Frame> render(const Camera& camera, const FrameOptions& options);
  // Draws into the framebuffer object `target` of the current context; 0 is a window's own. No read-back, and no waiting:
  // ground that still has to be read from a file is drawn coarser, without holes and never above a road.
  // Errors: as render.
  Status draw(const Camera& camera, int width, int height, int samples, unsigned target = 0);

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace roadgen
