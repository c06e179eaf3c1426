#include "roadgen/import/osm_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include <osmium/io/any_input.hpp>
#include <osmium/osm/node.hpp>
#include <osmium/osm/way.hpp>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

constexpr OsmLocation kNowhere{osmium::Location::undefined_coordinate, osmium::Location::undefined_coordinate};

std::string way_name(std::int64_t id) { return "way " + std::to_string(id); }

// A file of at most this size is read in one pass, all its nodes kept; a larger one in two.
constexpr std::uintmax_t kOnePass_bytes = 32 << 20;

// The file as libosmium takes it; bytes: where its content is put, to live as long. libosmium 2.19 leaves a PBF that it
// cannot read open: small ones are handed over in memory.
osmium::io::File opened(const std::string& path, std::string& bytes) {
  osmium::io::File file(path);
  if (file.format() != osmium::io::file_format::pbf || std::filesystem::file_size(path) > kOnePass_bytes) return file;
  std::ifstream stream(path, std::ios::binary);
  bytes.assign(std::istreambuf_iterator<char>(stream), {});
  if (!stream) throw std::runtime_error("reading fails");
  return osmium::io::File(bytes.data(), bytes.size(), "pbf");
}

// The file's objects of the given kinds, one after the other. Throws what libosmium throws.
template <class Visit>
void for_each(const std::string& path, osmium::osm_entity_bits::type kinds, const Visit& visit) {
  std::string bytes;
  osmium::io::Reader reader(opened(path, bytes), kinds, osmium::io::read_meta::no);
  while (const osmium::memory::Buffer buffer = reader.read()) {
    for (const osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) visit(object);
  }
  reader.close();
}

struct PlacedNode {
  std::int64_t id;
  OsmLocation at;
};

// kNowhere where it is deleted or not on the Earth.
PlacedNode placed(const osmium::OSMObject& object) {
  const auto& node = static_cast<const osmium::Node&>(object);
  if (!node.visible() || !node.location().valid()) return {node.id(), kNowhere};
  return {node.id(), {node.location().x(), node.location().y()}};
}

// libosmium keeps keys and values one behind the other, each ended by a zero byte. Those of a PBF may hold more of them,
// and an odd number would lead whoever walks the list beyond its end.
bool is_walkable(const osmium::TagList& tags) {
  const auto* const begin = reinterpret_cast<const char*>(&tags);
  const char *const first = begin + sizeof(osmium::TagList), *const end = begin + tags.byte_size();
  return first == end || (end[-1] == 0 && std::count(first, end, '\0') % 2 == 0);
}

struct TooMuch {
  std::size_t limit;
  const char* of;
};
void expect_at_most(std::size_t limit, std::size_t count, const char* of) {
  if (count > limit) throw TooMuch{limit, of};
}

class OsmReader {
 public:
  OsmReader(const std::string& path, ElementFindings& findings, const OsmLimits& limits)
      : path_(path), findings_(findings), limits_(limits) {}
  Result<OsmData> run();

 private:
  void read_all();
  void take_way(const osmium::Way& way);
  void want_nodes();
  void take_node(const PlacedNode& node);
  void resolve();
  void take_part(const OsmWay& way, std::size_t begin, std::size_t end);

  const std::string& path_;
  ElementFindings& findings_;
  const OsmLimits& limits_;
  OsmData data_;
  std::vector<OsmWay> ways_;        // as in the file: first and count of refs_
  std::vector<std::int64_t> refs_;  // ids of nodes
  std::unordered_map<std::string, std::uint32_t> names_;
  std::unordered_set<std::int64_t> seen_;  // ways
  std::size_t next_ = 0;                   // of node_ids: files are sorted by id as a rule, so the next one is near
};

void OsmReader::take_way(const osmium::Way& way) {
  const osmium::TagList& list = way.tags();
  if (!way.visible()) return;
  if (!is_walkable(list)) {
    findings_.add(Severity::kWarning, "tags without sense", way_name(way.id()), "a zero byte in its tags: left out");
    return;
  }
  if (!list.has_key("highway")) return;
  ParsedTags parsed = parse_tags([&](const char* key) { return list.get_value_by_key(key); });
  if (!parsed.drivable) return;
  if (!seen_.insert(way.id()).second) {
    findings_.add(Severity::kWarning, "ways that occur twice", way_name(way.id()), "occurs twice: the first one holds");
    return;
  }
  for (const std::string& fault : parsed.faults) {
    findings_.add(Severity::kWarning, "tags without sense", way_name(way.id()), fault + ": the default holds");
  }
  OsmWay kept{way.id(), parsed.tags, static_cast<std::uint32_t>(refs_.size()), 0};
  if (const char* name = list.get_value_by_key("name")) {
    const auto [at, is_new] = names_.try_emplace(name, static_cast<std::uint32_t>(data_.names.size()));
    if (is_new) data_.names.emplace_back(name);
    kept.tags.name = at->second;
  }
  for (const osmium::NodeRef& ref : way.nodes()) {
    if (refs_.size() > kept.first && refs_.back() == ref.ref()) continue;
    refs_.push_back(ref.ref());
  }
  expect_at_most(limits_.refs, refs_.size(), "nodes of ways to drive on");
  if (parsed.reversed) std::reverse(refs_.begin() + kept.first, refs_.end());
  kept.count = static_cast<std::uint32_t>(refs_.size()) - kept.first;
  ways_.push_back(kept);
  expect_at_most(limits_.ways, ways_.size(), "ways to drive on");
}

void OsmReader::want_nodes() {
  names_ = {};
  seen_ = {};
  std::vector<std::int64_t>& ids = data_.node_ids;
  ids = refs_;
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  ids.shrink_to_fit();
  data_.locations.assign(ids.size(), kNowhere);
}

void OsmReader::take_node(const PlacedNode& node) {
  const std::vector<std::int64_t>& ids = data_.node_ids;
  if (next_ < ids.size() && ids[next_] < node.id) ++next_;
  if (next_ == ids.size() || ids[next_] != node.id) {
    if (next_ < ids.size() && next_ > 0 && ids[next_ - 1] < node.id && node.id < ids[next_]) return;
    next_ = static_cast<std::size_t>(std::lower_bound(ids.begin(), ids.end(), node.id) - ids.begin());
    if (next_ == ids.size() || ids[next_] != node.id) return;
  }
  OsmLocation& place = data_.locations[next_];
  if (node.at.longitude == kNowhere.longitude) return;
  if (place.longitude == kNowhere.longitude) {
    place = node.at;
    return;
  }
  findings_.add(Severity::kWarning, "nodes that occur twice", "node " + std::to_string(node.id),
                "occurs twice: the first one holds");
}

void OsmReader::read_all() {
  using osmium::osm_entity_bits::node;
  using osmium::osm_entity_bits::way;
  data_.names.emplace_back();
  const auto take = [&](const osmium::OSMObject& object) { take_way(static_cast<const osmium::Way&>(object)); };
  if (std::filesystem::file_size(path_) > kOnePass_bytes) {
    for_each(path_, way, take);
    want_nodes();
    for_each(path_, node, [&](const osmium::OSMObject& object) { take_node(placed(object)); });
    return;
  }
  std::vector<PlacedNode> nodes;
  for_each(path_, node | way, [&](const osmium::OSMObject& object) {
    if (object.type() == osmium::item_type::way) {
      take(object);
    } else {
      nodes.push_back(placed(object));
      expect_at_most(limits_.one_pass_nodes, nodes.size(), "nodes");
    }
  });
  want_nodes();
  for (const PlacedNode& one : nodes) take_node(one);
}

// The part of a way between missing nodes.
void OsmReader::take_part(const OsmWay& way, std::size_t begin, std::size_t end) {
  if (end - begin < 2) return;
  OsmWay part = way;
  part.first = static_cast<std::uint32_t>(data_.refs.size());
  for (std::size_t i = begin; i < end; ++i) {
    const auto at = std::lower_bound(data_.node_ids.begin(), data_.node_ids.end(), refs_[i]);
    data_.refs.push_back(static_cast<std::uint32_t>(at - data_.node_ids.begin()));
  }
  part.count = static_cast<std::uint32_t>(data_.refs.size()) - part.first;
  data_.ways.push_back(part);
}

void OsmReader::resolve() {
  data_.ways.reserve(ways_.size());
  data_.refs.reserve(refs_.size());
  const auto is_missing = [&](std::int64_t id) {
    const auto at = std::lower_bound(data_.node_ids.begin(), data_.node_ids.end(), id) - data_.node_ids.begin();
    return data_.locations[static_cast<std::size_t>(at)].longitude == kNowhere.longitude;
  };
  for (const OsmWay& way : ways_) {
    std::size_t missing = 0, begin = way.first;
    const std::size_t end = way.first + way.count, before = data_.ways.size();
    std::int64_t first_missing = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_missing(refs_[i])) continue;
      if (missing++ == 0) first_missing = refs_[i];
      take_part(way, begin, i);
      begin = i + 1;
    }
    take_part(way, begin, end);
    if (missing > 0) {
      findings_.add(Severity::kWarning, "ways with missing nodes", way_name(way.id),
                    std::to_string(missing) + " of its " + std::to_string(way.count) +
                        " nodes are missing or have no place on the Earth, the first is node " +
                        std::to_string(first_missing) + ": cut there");
    }
    if (data_.ways.size() == before) {
      findings_.add(Severity::kWarning, "ways of fewer than two nodes", way_name(way.id),
                    "has fewer than two nodes: left out");
    }
  }
  ways_ = {};
  refs_ = {};
}

Result<OsmData> OsmReader::run() {
  if (Status status = check_is_file(path_); !status) return status.error();
  try {
    read_all();
  } catch (const TooMuch& found) {
    return Error{ErrorCode::kData,
                 "holds more than " + std::to_string(found.limit) + " " + found.of + "; cut out the part that you need",
                 path_};
  } catch (const std::exception& fault) {
    std::string what = fault.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    return Error{ErrorCode::kParse, "cannot be read (truncated or damaged?): " + what, path_};
  }
  resolve();
  if (data_.ways.empty()) return Error{ErrorCode::kData, "holds no way to drive on (highway=*)", path_};
  return std::move(data_);
}

}  // namespace

ElementFindings::Kind& ElementFindings::kind_of(const char* name) {
  for (Kind& kind : kinds_) {
    if (std::string_view(kind.name) == name) return kind;
  }
  return kinds_.emplace_back(Kind{name, 0, {}});
}

void ElementFindings::add(Severity severity, const char* kind, std::string element, std::string message) {
  Kind& of = kind_of(kind);
  if (of.count++ < kMostOfAKind) of.told.push_back({severity, std::move(message), file_, 0, std::move(element)});
}

void ElementFindings::add(const ElementFindings& other) {
  for (const Kind& theirs : other.kinds_) {
    Kind& ours = kind_of(theirs.name);
    ours.count += theirs.count;
    for (const Diagnostic& d : theirs.told) {
      if (ours.told.size() < kMostOfAKind) ours.told.push_back(d);
    }
  }
}

void ElementFindings::append_to(Diagnostics& diagnostics) const {
  for (const Kind& kind : kinds_) {
    diagnostics.insert(diagnostics.end(), kind.told.begin(), kind.told.end());
    if (kind.count > kind.told.size()) {
      diagnostics.push_back(
          {kind.told.front().severity, std::to_string(kind.count - kind.told.size()) + " more " + kind.name, file_});
    }
  }
}

bool is_osm_file(const std::string& path) {
  std::string name = path;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* ending : {".osm", ".osm.gz", ".osm.bz2", ".pbf"}) {
    if (name.ends_with(ending)) return true;
  }
  return false;
}

Result<OsmData> read_osm(const std::string& path, ElementFindings& findings, const OsmLimits& limits) {
  return OsmReader(path, findings, limits).run();
}

}  // namespace roadgen
