#include "roadgen/export/gltf.h"

#include <cstring>
#include <map>
#include <span>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

namespace roadgen {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUnsignedInt = 5125;            // component types
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;  // targets of buffer views

Json triple(glm::dvec3 v) { return {v.x, v.y, v.z}; }

class Document {
 public:
  Document(const NetworkMesh& mesh, const std::optional<Georeference>& origin) {
    Json extras = {{"error_m", mesh.error_m}};
    if (origin) extras["origin"] = {origin->latitude_deg, origin->longitude_deg, origin->height_m};
    json_ = {{"asset", {{"version", "2.0"}, {"generator", "roadgen"}, {"extras", extras}}}, {"scene", 0}};
    Json children = Json::array();
    for (std::size_t i = 0; i < mesh.items.size(); ++i) children.push_back(i + 1);
    Json root = {{"name", "network, ENU"}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}};
    if (!children.empty()) root["children"] = children;
    json_["scenes"] = {{{"nodes", {0}}}};
    json_["nodes"].push_back(root);
    for (const MeshItem& item : mesh.items) add(item);
    if (!binary_.empty()) json_["buffers"] = {{{"byteLength", binary_.size()}}};
  }

  Result<std::string> bytes() const {
    std::string text = json_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    if (total > 0xffffffffu) {
      return Error{ErrorCode::kData, "the mesh is too large for one glTF file; allow a greater error"};
    }
    std::string result;
    result.reserve(total);
    const auto word = [&result](std::size_t value) {
      const auto w = static_cast<std::uint32_t>(value);
      result.append(reinterpret_cast<const char*>(&w), sizeof w);
    };
    result += "glTF";
    word(2), word(total);
    word(text.size());
    result += "JSON";
    result += text;
    if (!binary_.empty()) {
      word(binary_.size());
      result.append("BIN\0", 4);
      result += binary_;
    }
    return result;
  }

 private:
  void add(const MeshItem& item) {
    Json primitives = Json::array();
    for (const MeshPart& part : item.parts) {
      glm::vec3 low = part.positions.front(), high = low;
      for (const glm::vec3& p : part.positions) low = glm::min(low, p), high = glm::max(high, p);
      const std::size_t position = accessor(std::span(part.positions), kFloat, "VEC3", kArrayBuffer);
      json_["accessors"][position]["min"] = {low.x, low.y, low.z};
      json_["accessors"][position]["max"] = {high.x, high.y, high.z};
      const std::size_t normal = accessor(std::span(part.normals), kFloat, "VEC3", kArrayBuffer);
      const std::size_t index = accessor(std::span(part.triangles), kUnsignedInt, "SCALAR", kElementBuffer);
      primitives.push_back({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                            {"indices", index},
                            {"material", material(part)}});
    }
    Json node = {{"name", item.name}, {"translation", triple(item.origin_m)}};
    if (!primitives.empty()) {
      node["mesh"] = json_["meshes"].size();
      json_["meshes"].push_back({{"name", item.name}, {"primitives", primitives}});
    }
    json_["nodes"].push_back(node);
  }

  template <class T>
  std::size_t accessor(std::span<const T> data, int component, const char* type, int target) {
    Json& views = json_["bufferViews"];
    Json& accessors = json_["accessors"];
    views.push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", data.size_bytes()}, {"target", target}});
    accessors.push_back(
        {{"bufferView", views.size() - 1}, {"componentType", component}, {"count", data.size()}, {"type", type}});
    binary_.append(reinterpret_cast<const char*>(data.data()), data.size_bytes());
    return accessors.size() - 1;
  }

  std::size_t material(const MeshPart& part) {
    const auto [at, is_new] = materials_.try_emplace(part.name, materials_.size());
    if (is_new) {
      const glm::dvec3 c = part.albedo;
      json_["materials"].push_back(
          {{"name", part.name},
           {"pbrMetallicRoughness",
            {{"baseColorFactor", {c.x, c.y, c.z, 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.9}}}});
    }
    return at->second;
  }

  Json json_;
  std::string binary_;
  std::map<std::string, std::size_t> materials_;
};

}  // namespace

Result<std::string> gltf_binary(const NetworkMesh& mesh, const std::optional<Georeference>& origin) {
  return Document(mesh, origin).bytes();
}

}  // namespace roadgen
