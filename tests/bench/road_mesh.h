// What the cookie-cut roads are compared with: the same scene with its roads tessellated, drawn as Renderer draws it
// (ground, sky, then roads) and shaded by the same functions.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "roadgen/render/camera.h"
#include "roadgen/render/shader_source.h"
#include "roadgen/road/result.h"
#include "tests/bench/base_scene.h"

namespace roadgen::bench {

// The road turns, horizontally and vertically together, by at most this from one row of vertices to the next. The first
// five are the paper's; the last ones are needed where half a pixel is held near the eye.
inline constexpr double kTurns_deg[] = {1, 2, 5, 10, 20, 0.5, 0.25};
inline constexpr int kPaperTurns = 5;
inline constexpr double kLodError_px = 0.5;

struct MeshMethod {
  enum Kind { kNoRoad, kTurn, kLevelOfDetail } kind = kNoRoad;
  int turn = 0;  // of kTurns_deg
  bool culling = false;
};

class MeshScene {
 public:
  // road_fragment: of tests/bench/shaders. Errors: kShader.
  static Result<MeshScene> create(const BaseScene& scene, std::span<const glm::dvec3> origins,
                                  const std::string& road_fragment = "road_mesh.frag",
                                  const ShaderDefines& defines = {});
  MeshScene(MeshScene&&) noexcept;
  MeshScene& operator=(MeshScene&&) noexcept;
  ~MeshScene();

  // Uniforms of road_texture.frag, whose texture is unit 0's: its size along s and t, and
  // with PROBES defined the greatest anisotropy.
  void set_texture(glm::dvec2 size_m, int probes);
  // Requires: a Renderer has just drawn the same roads with the same camera and size in this context; its frame uniforms
  // and tables are still bound.
  Status draw(const Camera& camera, int width, int height, int samples, unsigned target, const MeshMethod& method);
  // Of the base scene's road.
  std::size_t triangles(int turn) const;
  // Of the last draw.
  std::size_t triangles_drawn() const;

 private:
  struct State;
  explicit MeshScene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace roadgen::bench
