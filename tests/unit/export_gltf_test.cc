// Files against the rules of glTF 2.0: what a validator checks of a file like ours, and that the check can fail.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <set>

#include <nlohmann/json.hpp>

#include "roadgen/export/gltf.h"
#include "roadgen/fit/catmull_rom.h"

namespace roadgen {
namespace {

using Json = nlohmann::json;

// Source: Khronos glTF 2.0 specification, sections 3 and 4. The first rule that a file breaks, or nothing.
class Validator {
 public:
  static std::string fault(const std::string& file) {
    try {
      Validator v;
      v.check(file);
      return {};
    } catch (const std::string& what) {
      return what;
    } catch (const std::exception& what) {
      return what.what();
    }
  }

 private:
  static void expect(bool good, const std::string& rule) {
    if (!good) throw rule;
  }
  static std::uint32_t word(const std::string& bytes, std::size_t at) {
    expect(at + 4 <= bytes.size(), "cut short");
    std::uint32_t w;
    std::memcpy(&w, bytes.data() + at, sizeof w);
    return w;
  }

  void check(const std::string& file) {
    expect(file.starts_with("glTF") && word(file, 4) == 2, "magic and version");
    expect(word(file, 8) == file.size(), "length in the header");
    const std::size_t json_size = word(file, 12);
    expect(word(file, 16) == 0x4E4F534A, "first chunk is JSON");
    expect(json_size % 4 == 0 && 20 + json_size <= file.size(), "JSON chunk's length");
    std::size_t at = 20 + json_size;
    if (at < file.size()) {
      const std::size_t size = word(file, at);
      expect(word(file, at + 4) == 0x004E4942, "second chunk is BIN");
      expect(size % 4 == 0 && at + 8 + size == file.size(), "BIN chunk's length");
      binary_ = file.substr(at + 8);
    }
    json_ = Json::parse(file.substr(20, json_size));
    check_top();
    for (const Json& view : list("bufferViews")) check_view(view);
    for (std::size_t i = 0; i < list("accessors").size(); ++i) check_accessor(list("accessors")[i]);
    for (const Json& mesh : list("meshes")) check_mesh(mesh);
    check_nodes();
    expect(used_accessors_.size() == list("accessors").size(), "an accessor is not used");
    expect(used_views_.size() == list("bufferViews").size(), "a buffer view is not used");
    expect(used_materials_.size() == list("materials").size(), "a material is not used");
    expect(used_meshes_.size() == list("meshes").size(), "a mesh is not used");
  }

  const Json& list(const char* name) const {
    static const Json none = Json::array();
    return json_.contains(name) ? json_.at(name) : none;
  }
  std::size_t index(const Json& from, const char* name, const char* of) const {
    expect(from.at(name).is_number_unsigned() || from.at(name).is_number_integer(), std::string(name) + " is an index");
    const auto i = from.at(name).get<std::size_t>();
    expect(i < list(of).size(), std::string(name) + " refers to " + of);
    return i;
  }

  void check_top() const {
    const std::set<std::string> known = {"asset",     "scene",     "scenes",      "nodes",  "meshes",
                                         "accessors", "materials", "bufferViews", "buffers"};
    for (const auto& [key, value] : json_.items()) {
      expect(known.contains(key), "unknown property " + key);
      expect(!value.is_array() || !value.empty(), key + " is empty");
    }
    expect(json_.at("asset").at("version") == "2.0", "asset.version");
    expect(list("buffers").size() == (binary_.empty() ? 0u : 1u), "one buffer");
    if (!binary_.empty()) {
      const auto size = list("buffers")[0].at("byteLength").get<std::size_t>();
      expect(size <= binary_.size() && binary_.size() - size < 4, "buffer's length");
      expect(!list("buffers")[0].contains("uri"), "the binary buffer has no uri");
    }
    for (const Json& material : list("materials")) {
      const Json& pbr = material.at("pbrMetallicRoughness");
      expect(pbr.at("baseColorFactor").size() == 4, "base colour");
      for (const Json& c : pbr.at("baseColorFactor")) expect(c >= 0.0 && c <= 1.0, "base colour's range");
      for (const char* f : {"metallicFactor", "roughnessFactor"}) expect(pbr.at(f) >= 0.0 && pbr.at(f) <= 1.0, f);
    }
  }

  void check_view(const Json& view) const {
    const auto offset = view.at("byteOffset").get<std::size_t>(), length = view.at("byteLength").get<std::size_t>();
    expect(index(view, "buffer", "buffers") == 0, "buffer");
    expect(length > 0 && offset % 4 == 0 && offset + length <= binary_.size(), "buffer view's place");
    expect(view.at("target") == 34962 || view.at("target") == 34963, "buffer view's target");
    expect(!view.contains("byteStride"), "stride");
  }

  // The accessor's numbers, which are tightly packed.
  template <class T>
  std::vector<T> data(const Json& accessor, std::size_t components) const {
    const Json& view = list("bufferViews")[accessor.at("bufferView").get<std::size_t>()];
    const auto count = accessor.at("count").get<std::size_t>() * components;
    expect(view.at("byteLength") == count * sizeof(T), "accessor fills its buffer view");
    std::vector<T> values(count);
    std::memcpy(values.data(), binary_.data() + view.at("byteOffset").get<std::size_t>(), count * sizeof(T));
    return values;
  }

  void check_accessor(const Json& accessor) {
    used_views_.insert(index(accessor, "bufferView", "bufferViews"));
    expect(accessor.at("count").get<std::int64_t>() >= 1, "accessor's count");
    expect(!accessor.contains("byteOffset") || accessor.at("byteOffset").get<int>() % 4 == 0, "accessor's alignment");
    const int component = accessor.at("componentType");
    const std::string type = accessor.at("type");
    expect((component == 5126 && type == "VEC3") || (component == 5125 && type == "SCALAR"), "component and type");
    if (component == 5125) return;
    const std::vector<float> values = data<float>(accessor, 3);
    for (const float x : values) expect(std::isfinite(x), "numbers are finite");
    if (!accessor.contains("min")) return;
    for (std::size_t c = 0; c < 3; ++c) {
      float low = values[c], high = values[c];
      for (std::size_t i = c; i < values.size(); i += 3)
        low = std::min(low, values[i]), high = std::max(high, values[i]);
      expect(accessor.at("min").at(c).get<float>() == low && accessor.at("max").at(c).get<float>() == high,
             "min and max are those of the data");
    }
  }

  void check_mesh(const Json& mesh) {
    expect(!mesh.at("primitives").empty(), "a mesh has primitives");
    for (const Json& primitive : mesh.at("primitives")) {
      const Json& attributes = primitive.at("attributes");
      const std::size_t position = index(attributes, "POSITION", "accessors");
      const std::size_t normal = index(attributes, "NORMAL", "accessors");
      const std::size_t indices = index(primitive, "indices", "accessors");
      used_accessors_.insert({position, normal, indices});
      used_materials_.insert(index(primitive, "material", "materials"));
      const Json &p = list("accessors")[position], &n = list("accessors")[normal], &i = list("accessors")[indices];
      expect(p.contains("min") && p.contains("max"), "POSITION has min and max");
      expect(p.at("type") == "VEC3" && n.at("type") == "VEC3" && i.at("type") == "SCALAR", "semantics");
      expect(p.at("count") == n.at("count"), "attributes are as many");
      for (const std::size_t a : {position, normal}) {
        const Json& view = list("bufferViews")[list("accessors")[a].at("bufferView").get<std::size_t>()];
        expect(view.at("target") == 34962, "target of attributes");
      }
      expect(list("bufferViews")[i.at("bufferView").get<std::size_t>()].at("target") == 34963, "target of indices");
      const std::vector<float> normals = data<float>(n, 3), positions = data<float>(p, 3);
      for (std::size_t k = 0; k < normals.size(); k += 3) {
        expect(std::abs(std::hypot(normals[k], normals[k + 1], normals[k + 2]) - 1) < 1e-3, "normals are unit");
      }
      const std::vector<std::uint32_t> all = data<std::uint32_t>(i, 1);
      expect(all.size() % 3 == 0, "triangles are whole");
      const auto count = p.at("count").get<std::uint32_t>();
      for (std::size_t k = 0; k < all.size(); k += 3) {
        for (std::size_t c = 0; c < 3; ++c) expect(all[k + c] < count, "index is in range");
        const auto same = [&](std::size_t a, std::size_t b) {
          return std::memcmp(&positions[3 * all[k + a]], &positions[3 * all[k + b]], 12) == 0;
        };
        expect(!same(0, 1) && !same(1, 2) && !same(2, 0), "no triangle is degenerate");
      }
    }
  }

  void check_nodes() {
    std::set<std::size_t> children, seen;
    for (const Json& node : list("nodes")) {
      if (node.contains("mesh")) used_meshes_.insert(index(node, "mesh", "meshes"));
      if (node.contains("rotation")) {
        double size = 0;
        for (const Json& x : node.at("rotation")) size += x.get<double>() * x.get<double>();
        expect(node.at("rotation").size() == 4 && std::abs(size - 1) < 1e-6, "rotation is a unit quaternion");
      }
      expect(!node.contains("translation") || node.at("translation").size() == 3, "translation");
      if (!node.contains("children")) continue;
      expect(!node.at("children").empty(), "children is empty");
      for (const Json& child : node.at("children")) {
        expect(child.get<std::size_t>() < list("nodes").size(), "child is a node");
        expect(children.insert(child.get<std::size_t>()).second, "a node has one parent");
      }
    }
    const std::function<void(std::size_t)> visit = [&](std::size_t i) {
      expect(seen.insert(i).second, "nodes are a tree");
      if (!list("nodes")[i].contains("children")) return;
      for (const Json& child : list("nodes")[i].at("children")) visit(child.get<std::size_t>());
    };
    const std::size_t scene = index(json_, "scene", "scenes");
    for (const Json& root : list("scenes")[scene].at("nodes")) {
      expect(root.get<std::size_t>() < list("nodes").size(), "root is a node");
      expect(!children.contains(root.get<std::size_t>()), "roots have no parents");
      visit(root.get<std::size_t>());
    }
    expect(seen.size() == list("nodes").size(), "every node is in the scene");
  }

  Json json_;
  std::string binary_;
  std::set<std::size_t> used_accessors_, used_views_, used_materials_, used_meshes_;
};

Network scene() {
  Result<Road> road =
      road_from_anchors(std::vector<Anchor>{{{0, 0}, 1, 4}, {{50, 5}, 2, 4}, {{100, -3}, 1, 4}, {{150, 0}, 0, 4}}, {});
  EXPECT_TRUE(road.ok());
  road->id = "r";
  road->sweeps = {{.s_start_m = 10, .s_end_m = 60, .shape = Tunnel{}},
                  {.s_end_m = road->length_m(), .t_m = 4.5, .shape = GuardRail{}},
                  {.s_end_m = road->length_m(), .t_m = -5, .shape = Cable{}}};
  road->paint = {{.kind = PaintKind::kZebra, .s_m = 80, .length_m = 3, .width_m = 7}};
  Network network;
  network.roads = {*road};
  return network;
}

std::string file_of(const Network& network) {
  const auto mesh = tessellate(network);
  EXPECT_TRUE(mesh.ok());
  const auto file = gltf_binary(*mesh, Georeference{48, 11, 500});
  EXPECT_TRUE(file.ok());
  return *file;
}

TEST(GltfRules, FilesKeepThem) {
  EXPECT_EQ(Validator::fault(file_of(scene())), "");
  EXPECT_EQ(Validator::fault(file_of(Network{})), "");
}

TEST(GltfRules, TheCheckCanFail) {
  const std::string good = file_of(scene());
  const auto text_end = [](const std::string& file) {
    std::uint32_t size;
    std::memcpy(&size, file.data() + 12, sizeof size);
    return 20 + size;
  };
  // With the JSON changed, the chunk kept as long as it was where the text allows.
  const auto changed = [&](const std::function<void(Json&)>& spoil) {
    Json json = Json::parse(good.substr(20, text_end(good) - 20));
    spoil(json);
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string file = good.substr(0, 12);
    const auto put = [&](std::size_t at, std::size_t value) {
      const auto w = static_cast<std::uint32_t>(value);
      std::memcpy(file.data() + at, &w, sizeof w);
    };
    file += std::string(4, '\0') + "JSON" + text + good.substr(text_end(good));
    put(12, text.size());
    put(8, file.size());
    return Validator::fault(file);
  };
  EXPECT_EQ(changed([](Json&) {}), "");
  EXPECT_EQ(changed([](Json& j) { j["asset"]["version"] = "1.0"; }), "asset.version");
  EXPECT_EQ(changed([](Json& j) { j["extra"] = 1; }), "unknown property extra");
  EXPECT_EQ(changed([](Json& j) { j["accessors"][0]["max"][0] = 1e6; }), "min and max are those of the data");
  EXPECT_EQ(changed([](Json& j) { j["accessors"][0]["count"] = 1; }), "accessor fills its buffer view");
  EXPECT_EQ(changed([](Json& j) { j["bufferViews"][2]["target"] = 34962; }), "target of indices");
  EXPECT_EQ(changed([](Json& j) { j["bufferViews"][1]["byteLength"] = 1e9; }), "buffer view's place");
  EXPECT_EQ(changed([](Json& j) { j["meshes"][0]["primitives"][0]["material"] = 99; }), "material refers to materials");
  EXPECT_EQ(changed([](Json& j) { j["nodes"][1]["children"] = {1}; }), "a node has one parent");
  EXPECT_EQ(changed([](Json& j) { j["nodes"][0]["rotation"][0] = 1; }), "rotation is a unit quaternion");
  EXPECT_EQ(changed([](Json& j) { j["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 2; }),
            "roughnessFactor");
  const auto with_bytes = [&](std::size_t at, std::uint32_t value) {
    std::string file = good;
    std::memcpy(file.data() + at, &value, sizeof value);
    return Validator::fault(file);
  };
  const Json json = Json::parse(good.substr(20, text_end(good) - 20));
  const auto start = [&](const char* attribute) {
    const Json& primitive = json["meshes"][0]["primitives"][0];
    const std::size_t accessor =
        *attribute ? primitive["attributes"][attribute].get<std::size_t>() : primitive["indices"].get<std::size_t>();
    const Json& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    return text_end(good) + 8 + view["byteOffset"].get<std::size_t>();
  };
  EXPECT_EQ(with_bytes(start("NORMAL"), 0x7FC00000), "numbers are finite");
  EXPECT_EQ(with_bytes(start("NORMAL"), 0x40000000), "normals are unit");
  EXPECT_EQ(with_bytes(start(""), 0xFFFFFFFF), "index is in range");
  EXPECT_EQ(with_bytes(8, 5), "length in the header");
  EXPECT_NE(Validator::fault(good.substr(0, good.size() - 4)), "");
}

}  // namespace
}  // namespace roadgen
