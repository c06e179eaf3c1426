#include "roadgen/render/placement.h"

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "roadgen/road/off_ground.h"

namespace roadgen {

namespace {

std::unordered_map<std::string_view, std::uint32_t> roads_by_id(const std::vector<Road>& roads) {
  std::unordered_map<std::string_view, std::uint32_t> by_id;
  for (std::uint32_t i = 0; i < roads.size(); ++i) by_id.emplace(roads[i].id, i);
  return by_id;
}

}  // namespace

Status place_on_roads(std::span<const Placement> placements, const RoadIndex& index, ObjectScene& scene) {
  if (placements.empty()) return Done{};
  const std::vector<Road>& roads = index.network().roads;
  const auto by_id = roads_by_id(roads);
  std::vector<RoadPlace> places;
  places.reserve(placements.size());
  for (const Placement& placement : placements) {
    const auto refuse = [&](const std::string& why) {
      return Error{ErrorCode::kData, why, placement.file, placement.line, placement.element};
    };
    const auto road = by_id.find(placement.road);
    if (road == by_id.end()) return refuse("there is no road '" + placement.road.substr(0, 60) + "' in the network");
    if (roads[road->second].segments.empty()) return refuse("the road '" + placement.road + "' has no segments");
    const double length = roads[road->second].length_m();
    if (!(placement.s_m >= 0 && placement.s_m <= length)) {
      return refuse("s must lie on the road: 0 to " + std::to_string(length));
    }
    places.push_back({road->second, placement.s_m, placement.t_m});
  }

  std::vector<RoadPose> poses(places.size());
  index.to_world(places, poses);
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const glm::dmat4 frame = placement_frame(poses[i], placements[i]);
    if (placements[i].kind == Placement::Kind::kObject) {
      Object& object = scene.objects[placements[i].index];
      object.transform = frame * object.transform;
    } else {
      transform(scene.sphere_sets[placements[i].index], frame);
    }
  }
  return Done{};
}

void stand_on_ground(std::span<const Placement> placements, const RoadIndex& index, const Terrain& terrain,
                     ObjectScene& scene) {
  const std::vector<Road>& roads = index.network().roads;
  const auto by_id = roads_by_id(roads);
  for (const Placement& placement : placements) {
    const std::uint32_t road = by_id.at(placement.road);
    const glm::dvec3 at = index.to_world({road, placement.s_m, placement.t_m}).position_m;
    if (is_off_ground(roads[road], placement.s_m) || index.to_road(glm::dvec2(at), 0)) continue;
    const double down_m = at.z - terrain.height_m(glm::dvec2(at));
    if (placement.kind == Placement::Kind::kObject) {
      scene.objects[placement.index].transform[3].z -= down_m;
    } else {
      scene.sphere_sets[placement.index].origin_m.z -= down_m;
    }
  }
}

}  // namespace roadgen
