#include "roadgen/import/scene_file.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <glm/matrix.hpp>

#include "roadgen/import/json_stream.h"
#include "roadgen/import/point_cloud.h"
#include "roadgen/import/scene_shapes.h"
#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

using Kind = JsonValue::Kind;

// Where an object stands: on a road or in the world, and how it is turned there.
struct Stand {
  glm::dmat4 transform{1.0};
  std::optional<Placement> place;
};

// Groups within groups.
constexpr int kMostGroups = 16;

class SceneReader {
 public:
  explicit SceneReader(const std::string& file)
      : file_(file), folder_(std::filesystem::path(file).parent_path().string()) {}

  Status member(const std::string& key, const JsonValue& value, std::size_t index);
  Result<SceneFile> finish();

 private:
  struct MaterialName {
    std::uint32_t index = 0;
    bool defined = false;
    std::optional<Error> used;  // what to say if it never is
  };

  Status read_version(const JsonNode& node);
  Status read_materials(const JsonNode& node);
  Status read_object(const JsonNode& node, const std::vector<Stand>& parents, int groups);
  Status read_group(const JsonNode& node, const std::vector<Stand>& stands, int groups);
  Status read_spheres(const JsonNode& node, const std::vector<Stand>& stands, const std::string& name,
                      std::uint32_t material);
  Status add_objects(const JsonNode& node, const std::string& type, const std::vector<Stand>& stands,
                     const std::string& name, std::uint32_t material);
  Result<std::vector<Stand>> read_stands(const JsonNode& node, const std::vector<Stand>& parents);
  Result<Stand> read_stand(const JsonNode& node);
  Result<Placement> read_place(const JsonNode& node);
  Result<std::uint32_t> read_material_name(const JsonNode& node);
  MaterialName& material(const std::string& name);
  void keep_place(const Stand& stand, Placement::Kind kind, std::size_t index);

  std::string file_, folder_;
  SceneFile read_;
  std::map<std::string, MaterialName> materials_;
  std::size_t spheres_ = 0;
  bool has_version_ = false;
};

Status SceneReader::member(const std::string& key, const JsonValue& value, std::size_t index) {
  const JsonNode node(value, JsonPath().at(key), file_);
  if (key == "version") return read_version(node);
  if (key == "materials") return read_materials(node);
  if (key != "objects") {
    return JsonNode(value, {}, file_).error("unknown key " + quoted(key) + "; known here: version, materials, objects");
  }
  return read_object(JsonNode(value, node.path().at(index), file_), {Stand{}}, 0);
}

Status SceneReader::read_version(const JsonNode& node) {
  const auto version = node.number();
  if (!version) return version.error();
  if (*version != 1) return node.error("this roadgen reads version 1");
  has_version_ = true;
  return Done{};
}

SceneReader::MaterialName& SceneReader::material(const std::string& name) {
  const auto [at, is_new] = materials_.try_emplace(name);
  if (is_new) {
    at->second.index = static_cast<std::uint32_t>(read_.scene.materials.size());
    read_.scene.materials.push_back({});
  }
  return at->second;
}

Status SceneReader::read_materials(const JsonNode& node) {
  if (Status s = node.expect(Kind::kObject); !s) return s;
  for (const auto& [name, value] : node.value().members) {
    const JsonNode one(value, node.path().at(name), file_);
    if (Status s = one.expect(Kind::kObject); !s) return s;
    MaterialName& known = material(name);
    if (known.defined) return one.error("the key " + quoted(name) + " stands here twice", ErrorCode::kParse);
    auto read = read_material(name, one, folder_);
    if (!read) return read.error();
    read_.scene.materials[known.index] = std::move(*read);
    known.defined = true;
  }
  return Done{};
}

Result<std::uint32_t> SceneReader::read_material_name(const JsonNode& node) {
  if (!node.has("material")) {
    MaterialName& standard = material("");
    standard.defined = true;
    return standard.index;
  }
  const auto at = node.at("material");
  const auto name = at->text();
  if (!name) return name.error();
  if (name->empty()) return at->error("the material's name is empty");
  MaterialName& known = material(*name);
  if (!known.defined && !known.used) {
    known.used = at->error("there is no material " + quoted(*name) + " in 'materials'");
  }
  return known.index;
}

Result<Placement> SceneReader::read_place(const JsonNode& node) {
  if (Status s = node.expect_keys({"road", "s", "t", "h", "heading"}); !s) return s.error();
  Placement place;
  const auto road = node.at("road");
  if (!road) return road.error();
  const auto id = road->text();
  if (!id) return id.error();
  place.road = *id;
  const std::pair<std::string_view, double*> numbers[] = {
      {"s", &place.s_m}, {"t", &place.t_m}, {"h", &place.h_m}, {"heading", &place.heading_rad}};
  for (const auto& [key, to] : numbers) {
    if (key != "s" && !node.has(key)) continue;
    const auto at = node.at(key);
    if (!at) return at.error();
    const auto x = at->number();
    if (!x) return x.error();
    *to = *x;
  }
  place.file = file_;
  place.line = node.line();
  place.element = node.path().text();
  return place;
}

Result<Stand> SceneReader::read_stand(const JsonNode& node) {
  Stand stand;
  if (node.has("transform")) {
    const auto map = read_transform(*node.at("transform"));
    if (!map) return map.error();
    stand.transform = *map;
  }
  if (node.has("place")) {
    auto place = read_place(*node.at("place"));
    if (!place) return place.error();
    stand.place = std::move(*place);
  }
  return stand;
}

// Where an object stands with all its instances, in every place where its group does.
Result<std::vector<Stand>> SceneReader::read_stands(const JsonNode& node, const std::vector<Stand>& parents) {
  const auto own = read_stand(node);
  if (!own) return own.error();
  std::vector<Stand> stands;
  if (!node.has("instances")) {
    stands.push_back(*own);
  } else {
    const auto list = node.at("instances");
    if (Status s = list->expect(Kind::kArray); !s) return s.error();
    if (own->place) return node.at("place")->error("with 'instances' the places stand there");
    for (std::size_t i = 0; i < list->value().items.size(); ++i) {
      const JsonNode item = list->item(i);
      if (Status s = item.expect_keys({"transform", "place"}); !s) return s.error();
      auto stand = read_stand(item);
      if (!stand) return stand.error();
      stand->transform = stand->transform * own->transform;
      stands.push_back(std::move(*stand));
    }
  }
  if (stands.size() * parents.size() > kMostObjects) return node.error("more than 10 million objects");
  std::vector<Stand> all;
  all.reserve(stands.size() * parents.size());
  for (const Stand& parent : parents) {
    for (const Stand& stand : stands) {
      if (stand.place && parent.place) {
        return node.error("an object of a group that stands on a road cannot stand on a road itself: use 'transform'");
      }
      all.push_back({parent.transform * stand.transform, parent.place ? parent.place : stand.place});
      if (stand.place && parent.transform != glm::dmat4(1.0)) {
        return node.error("an object on a road cannot be moved by its group: use 'place' at the group");
      }
    }
  }
  return all;
}

Status SceneReader::read_object(const JsonNode& node, const std::vector<Stand>& parents, int groups) {
  if (Status s = node.expect(Kind::kObject); !s) return s;
  const auto type_at = node.at("type");
  if (!type_at) return type_at.error();
  const auto type = type_at->text();
  if (!type) return type.error();
  std::string name;
  if (node.has("name")) {
    const auto text = node.at("name")->text();
    if (!text) return text.error();
    name = *text;
  }
  const auto stands = read_stands(node, parents);
  if (!stands) return stands.error();
  if (*type == "group") return read_group(node, *stands, groups + 1);
  const auto material = read_material_name(node);
  if (!material) return material.error();
  if (*type == "spheres") return read_spheres(node, *stands, name, *material);
  return add_objects(node, *type, *stands, name, *material);
}

Status SceneReader::read_group(const JsonNode& node, const std::vector<Stand>& stands, int groups) {
  if (groups > kMostGroups) return node.error("groups are nested too deep: more than 16");
  if (Status s = node.expect_keys({"type", "name", "transform", "place", "instances", "objects"}); !s) return s;
  const auto list = node.at("objects");
  if (!list) return list.error();
  if (Status s = list->expect(Kind::kArray); !s) return s;
  for (std::size_t i = 0; i < list->value().items.size(); ++i) {
    if (Status s = read_object(list->item(i), stands, groups); !s) return s;
  }
  return Done{};
}

void SceneReader::keep_place(const Stand& stand, Placement::Kind kind, std::size_t index) {
  if (!stand.place) return;
  read_.placements.push_back(*stand.place);
  read_.placements.back().kind = kind;
  read_.placements.back().index = index;
}

Status SceneReader::add_objects(const JsonNode& node, const std::string& type, const std::vector<Stand>& stands,
                                const std::string& name, std::uint32_t material) {
  auto shape = read_shape(type, node);
  if (!shape) return shape.error();
  std::vector<Object>& objects = read_.scene.objects;
  if (objects.size() + stands.size() > kMostObjects) return node.error("more than 10 million objects");
  // What the object library has to say about it. Its index there means nothing here.
  ObjectScene alone{{{name, *shape, glm::dmat4(1.0), 0}}, {}, {}};
  for (const Stand& stand : stands) {
    alone.objects.front().transform = stand.transform;
    const Diagnostics faults = check(alone, 1);
    if (!faults.empty()) return node.error(faults.front().message);
    keep_place(stand, Placement::Kind::kObject, objects.size());
    objects.push_back({name, *shape, stand.transform, material});
  }
  return Done{};
}

Status SceneReader::read_spheres(const JsonNode& node, const std::vector<Stand>& stands, const std::string& name,
                                 std::uint32_t material) {
  if (Status s = expect_object_keys(node, {"file", "radius"}); !s) return s;
  const auto file_at = node.at("file");
  if (!file_at) return file_at.error();
  const auto file = file_at->text();
  if (!file) return file.error();
  PointCloudOptions options;
  if (node.has("radius")) {
    const auto radius = node.at("radius")->number();
    if (!radius) return radius.error();
    if (!(*radius > 0)) return node.at("radius")->error("the radius must be greater than 0");
    options.radius = *radius;
  }
  for (const Stand& stand : stands) {
    const Diagnostics faults = check(ObjectScene{{{name, Sphere{}, stand.transform, 0}}, {}, {}}, 1);
    if (!faults.empty()) return node.error(faults.front().message);
    if (!is_similarity(stand.transform)) {
      return node.error("the transform of spheres must scale evenly, else they are none");
    }
  }
  const auto set = read_point_cloud((std::filesystem::path(folder_) / *file).string(), options);
  if (!set) return set.error();
  for (const Stand& stand : stands) {
    spheres_ += set->items.size();
    if (spheres_ > kMostPoints) return node.error("more than 50 million spheres with all instances");
    keep_place(stand, Placement::Kind::kSphereSet, read_.scene.sphere_sets.size());
    read_.scene.sphere_sets.push_back(*set);
    SphereSet& added = read_.scene.sphere_sets.back();
    transform(added, stand.transform);
    added.material = material;
    if (!name.empty()) added.name = name;
  }
  return Done{};
}

Result<SceneFile> SceneReader::finish() {
  if (!has_version_) return Error{ErrorCode::kData, "the key 'version' is missing", file_};
  for (const auto& [name, known] : materials_) {
    if (!known.defined) return *known.used;
  }
  return std::move(read_);
}

}  // namespace

Result<SceneFile> parse_scene(std::string_view text, const std::string& file) {
  SceneReader reader(file);
  const Status status =
      read_json(text, file, "objects", [&](const std::string& key, const JsonValue& value, std::size_t index) {
        return reader.member(key, value, index);
      });
  if (!status) return status.error();
  return reader.finish();
}

Result<SceneFile> read_scene(const std::string& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  return parse_scene(*text, path);
}

}  // namespace roadgen
