#include "terrain/terrain_file.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <type_traits>
#include <utility>

#include "terrain/mapped_file.h"
#include "terrain/terrain_impl.h"

namespace roadgen {
namespace {

constexpr char kMagic[8] = {'r', 'o', 'a', 'd', 'g', 'n', 'd', '3'};  // the last: of the format
constexpr std::size_t kAlign = 4;  // of every array in the file, whose elements are multiples of it: no gaps

// The file: this, the table, filled up to a multiple of kAlign, and the arrays that the table tells the places of.
struct Head {
  char magic[8];
  std::uint64_t key, table_bytes, table_sum, file_bytes;
};
static_assert(sizeof(Head) == 40);

// FNV-1a of 64 bits by words of 8 bytes. Source: Fowler, Noll and Vo.
class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const char* at = static_cast<const char*>(data);
    for (; bytes >= 8; at += 8, bytes -= 8) {
      std::uint64_t word;
      std::memcpy(&word, at, 8);
      mix(word);
    }
    std::uint64_t rest = 0;
    if (bytes > 0) std::memcpy(&rest, at, bytes);  // of no bytes there may be no place either
    mix(rest ^ (std::uint64_t{bytes} << 56));
  }
  template <class T>
  void add_value(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    add(&value, sizeof value);
  }
  std::uint64_t value() const { return hash_; }

 private:
  void mix(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x100000001b3u;
    hash_ ^= hash_ >> 32;  // words' high bits reach the low ones
  }
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const char* bytes = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(std::uint64_t{values.size()});
    if constexpr (std::is_trivially_copyable_v<T>) {
      const char* bytes = reinterpret_cast<const char*>(values.data());
      bytes_.insert(bytes_.end(), bytes, bytes + values.size() * sizeof(T));
    } else {
      for (const T& value : values) exchange(*this, value);
    }
  }
  // Filled up to a multiple of kAlign.
  std::vector<char> bytes() && {
    bytes_.resize((bytes_.size() + kAlign - 1) / kAlign * kAlign);
    return std::move(bytes_);
  }

 private:
  std::vector<char> bytes_;
};

// Requires bytes whose checksum is right: what is asked for is there. Lengths are checked nevertheless.
class Reader {
 public:
  explicit Reader(std::span<const char> bytes) : bytes_(bytes) {}
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    take(&value, sizeof value);
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > bytes_.size() - at_) failed_ = true;
    if (failed_) return;
    values.resize(count);
    if constexpr (std::is_trivially_copyable_v<T>) {
      take(values.data(), count * sizeof(T));
    } else {
      for (T& value : values) exchange(*this, value);
    }
  }
  bool good() const { return !failed_ && bytes_.size() - at_ < kAlign; }

 private:
  void take(void* to, std::size_t count) {
    if (failed_ || count > bytes_.size() - at_) {
      failed_ = true;
      return;
    }
    if (count > 0) std::memcpy(to, bytes_.data() + at_, count);
    at_ += count;
  }
  std::span<const char> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

template <class Archive, class Cut>
requires std::is_same_v<std::remove_const_t<Cut>, TerrainMesh::Cut>
void exchange(Archive& with, Cut& cut) {
  with(cut.first);
  with(cut.count);
  with(cut.hollows);
}

template <class Archive, class T>
requires std::is_same_v<std::remove_const_t<T>, Hall>
void exchange(Archive& with, T& hall) {
  with(hall.height_m);
  with(hall.surface.center_m);
  with(hall.surface.cuts);
  with(hall.surface.corners);
  with(hall.surface.low_m);
  with(hall.surface.high_m);
  with(hall.surface.plane);
  with(hall.surface.slope_spread);
  with(hall.surface.plane_gap_m);
}

// Of an array: where it begins, from the first of them, and how long it is.
template <class T>
struct Place {
  std::uint64_t first = 0, count = 0;
};

// A tile in the table.
struct TileRecord {
  glm::dvec3 origin_m{0, 0, 0};
  glm::vec3 low_m{0, 0, 0}, high_m{0, 0, 0};
  std::array<std::array<std::uint32_t, 3>, 2> roots{};
  std::vector<TerrainMesh::Band> bands;
  std::vector<std::uint64_t> sums;  // checksums of the bands
  std::vector<std::uint32_t> cut_triangles;
  std::vector<TerrainMesh::Cut> cuts;
  std::vector<Hollow> hollows;
  Place<glm::vec3> positions, normals;
  Place<float> road, error, radius;
  Place<TerrainMesh::Node> nodes;
};

// All that is read at once.
struct Table {
  TerrainReport report;
  double unit_m = 1;
  glm::dvec2 origin_m{0, 0};
  std::int32_t k = 1;
  glm::ivec2 tile_count{1, 1};
  std::vector<Hollow> hollows;
  std::vector<Hall> halls;
  Place<std::int32_t> height_nodes;
  Place<HeightMesh::Leaf> height_leaves;
  std::uint64_t heights_sum = 0;
  std::vector<TileRecord> tiles;
};

template <class Archive, class Record>
requires std::is_same_v<std::remove_const_t<Record>, TileRecord>
void exchange(Archive& with, Record& tile) {
  with(tile.origin_m);
  with(tile.low_m);
  with(tile.high_m);
  with(tile.roots);
  with(tile.bands);
  with(tile.sums);
  with(tile.cut_triangles);
  with(tile.cuts);
  with(tile.hollows);
  with(tile.positions);
  with(tile.normals);
  with(tile.road);
  with(tile.error);
  with(tile.radius);
  with(tile.nodes);
}

template <class Archive, class T>
requires std::is_same_v<std::remove_const_t<T>, Table>
void exchange(Archive& with, T& table) {
  with(table.report);
  with(table.unit_m);
  with(table.origin_m);
  with(table.k);
  with(table.tile_count);
  with(table.hollows);
  with(table.halls);
  with(table.height_nodes);
  with(table.height_leaves);
  with(table.heights_sum);
  with(table.tiles);
}

// Of what the bands from first to last - 1 hold.
std::uint64_t checksum(const GroundTile& tile, std::uint32_t first, std::uint32_t last) {
  const std::uint32_t v0 = first == 0 ? 0 : tile.bands[first - 1].vertices, v1 = tile.bands[last - 1].vertices;
  const std::uint32_t n0 = first == 0 ? 0 : tile.bands[first - 1].nodes, n1 = tile.bands[last - 1].nodes;
  Hash hash;
  const auto add = [&](const auto& span, std::uint32_t from, std::uint32_t to) {
    hash.add(span.data() + from, (to - from) * sizeof(span[0]));
  };
  add(tile.positions_m, v0, v1);
  add(tile.normals, v0, v1);
  add(tile.road_m, v0, v1);
  add(tile.vertex_error_m, v0, v1);
  add(tile.vertex_radius_m, v0, v1);
  add(tile.nodes, n0, n1);
  return hash.value();
}

std::uint64_t checksum(const HeightMesh& heights) {
  Hash hash;
  hash.add(heights.nodes().data(), heights.nodes().size_bytes());
  hash.add(heights.leaves().data(), heights.leaves().size_bytes());
  return hash.value();
}

// Arrays one after the other.
class Arrays {
 public:
  template <class T>
  Place<T> add(std::span<const T> values) {
    static_assert(sizeof(T) % kAlign == 0 && alignof(T) == kAlign);
    const Place<T> place{size_, values.size()};
    parts_.push_back(std::as_bytes(values));
    size_ += values.size_bytes();
    return place;
  }
  std::size_t size() const { return size_; }
  void write(std::ofstream& file) const {
    for (const std::span<const std::byte> part : parts_) {
      file.write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(part.size()));
    }
  }

 private:
  std::vector<std::span<const std::byte>> parts_;
  std::size_t size_ = 0;
};

TileRecord record_of(const GroundTile& tile, Arrays& arrays) {
  const auto copy = [](const auto& span) { return std::vector(span.begin(), span.end()); };
  TileRecord record;
  record.origin_m = tile.origin_m;
  record.low_m = tile.low_m;
  record.high_m = tile.high_m;
  record.roots = tile.roots;
  record.bands = copy(tile.bands);
  for (std::uint32_t i = 0; i < tile.bands.size(); ++i) record.sums.push_back(checksum(tile, i, i + 1));
  record.cut_triangles = copy(tile.cut_triangles);
  record.cuts = copy(tile.cuts);
  record.hollows = copy(tile.hollows);
  record.positions = arrays.add(tile.positions_m);
  record.normals = arrays.add(tile.normals);
  record.road = arrays.add(tile.road_m);
  record.error = arrays.add(tile.vertex_error_m);
  record.radius = arrays.add(tile.vertex_radius_m);
  record.nodes = arrays.add(tile.nodes);
  return record;
}

// The tiles where the file has them.
class InFile : public GroundSource {
 public:
  // Requires: a table whose checksum is right. Errors: where arrays do not lie within the file.
  static std::shared_ptr<const InFile> of(std::shared_ptr<const MappedFile> file, std::size_t arrays_at, Table table) {
    std::shared_ptr<InFile> made(new InFile(std::move(file), arrays_at, std::move(table)));
    for (const TileRecord& record : made->table_.tiles) {
      if (!made->add(record)) return nullptr;
    }
    return made;
  }
  const Table& table() const { return table_; }

  // Where an array lies; empty, and not as long as it should be, where the file is too short for it.
  template <class T>
  std::span<const T> at(const Place<T>& place) const {
    const std::span<const char> bytes = file_->bytes();
    const std::size_t first = arrays_at_ + place.first;
    if (place.first > bytes.size() || first > bytes.size() || first % alignof(T) != 0) return {};
    if (place.count > (bytes.size() - first) / sizeof(T)) return {};
    return {reinterpret_cast<const T*>(bytes.data() + first), place.count};
  }

  std::span<const GroundTile> tiles() const override { return tiles_; }
  bool is_in_memory() const override { return false; }
  Status load(std::size_t tile, std::uint32_t first, std::uint32_t last) const override {
    for (std::uint32_t i = first; i < last; ++i) {
      if (checksum(tiles_[tile], i, i + 1) == table_.tiles[tile].sums[i]) continue;
      return Error{ErrorCode::kData, "the terrain file is damaged"};
    }
    return Done{};
  }
  void release(std::size_t tile) const override {
    const GroundTile& t = tiles_[tile];
    // From the first array of a tile to the last they lie one after the other.
    const char* begin = reinterpret_cast<const char*>(t.positions_m.data());
    const char* end = reinterpret_cast<const char*>(t.nodes.data() + t.nodes.size());
    file_->release({begin, static_cast<std::size_t>(end - begin)});
  }

 private:
  InFile(std::shared_ptr<const MappedFile> file, std::size_t arrays_at, Table table)
      : file_(std::move(file)), arrays_at_(arrays_at), table_(std::move(table)) {}

  bool add(const TileRecord& record) {
    GroundTile& tile = tiles_.emplace_back();
    tile.origin_m = record.origin_m;
    tile.low_m = record.low_m;
    tile.high_m = record.high_m;
    tile.roots = record.roots;
    tile.bands = record.bands;
    tile.cut_triangles = record.cut_triangles;
    tile.cuts = record.cuts;
    tile.hollows = record.hollows;
    tile.positions_m = at(record.positions);
    tile.normals = at(record.normals);
    tile.road_m = at(record.road);
    tile.vertex_error_m = at(record.error);
    tile.vertex_radius_m = at(record.radius);
    tile.nodes = at(record.nodes);
    if (record.bands.empty() || record.sums.size() != record.bands.size()) return false;
    const std::size_t vertices = record.bands.back().vertices;
    return tile.positions_m.size() == vertices && tile.normals.size() == vertices && tile.road_m.size() == vertices &&
           tile.vertex_error_m.size() == vertices && tile.vertex_radius_m.size() == vertices &&
           tile.nodes.size() == record.bands.back().nodes;
  }

  std::shared_ptr<const MappedFile> file_;
  std::size_t arrays_at_;
  Table table_;
  std::vector<GroundTile> tiles_;
};

Error data_error(const char* what, const std::string& path) { return Error{ErrorCode::kData, what, path}; }

}  // namespace

std::uint64_t terrain_key(std::string_view network_file, const Elevation* elevation, const TerrainOptions& options) {
  Hash hash;
  hash.add(ROADGEN_VERSION, std::strlen(ROADGEN_VERSION));
  hash.add(network_file.data(), network_file.size());
  if (elevation != nullptr) {
    const Grid& posts = elevation->posts();
    for (const double x :
         {posts.origin_m.x, posts.origin_m.y, posts.step_m.x, posts.step_m.y, elevation->extent().low.x,
          elevation->extent().low.y, elevation->extent().high.x, elevation->extent().high.y}) {
      hash.add_value(x);
    }
    hash.add_value(posts.columns);
    hash.add_value(elevation->is_geographic());
    hash.add(posts.values.data(), posts.values.size() * sizeof(float));
  }
  const LevellingOptions& l = options.levelling;
  for (const double x :
       {options.margin_m, options.spacing_m, options.least_clearance_m, options.most_clearance_m, options.tolerance_m,
        options.tolerance_per_m, options.rolling_m, l.gap_m, l.shoulder_m, l.cut_slope, l.fill_slope, l.cover_m,
        l.reach_m, l.ditch_depth_m, l.ditch_bottom_m, l.ditch_inner_slope, l.ditch_outer_slope}) {
    hash.add_value(x);
  }
  hash.add_value(options.max_triangles);
  return hash.value();
}

Status write_terrain_file(const Terrain& terrain, std::uint64_t key, const std::string& path) {
  const Terrain::Impl& impl = *terrain.impl_;
  Arrays arrays;
  Table table{impl.report, impl.unit_m, impl.origin_m,          impl.k, impl.tile_count, impl.hollows, impl.halls,
              {},          {},          checksum(impl.heights), {}};
  table.height_nodes = arrays.add(impl.heights.nodes());
  table.height_leaves = arrays.add(impl.heights.leaves());
  for (const GroundTile& tile : impl.stored->tiles()) table.tiles.push_back(record_of(tile, arrays));
  Writer writer;
  exchange(writer, std::as_const(table));
  const std::vector<char> bytes = std::move(writer).bytes();
  Hash sum;
  sum.add(bytes.data(), bytes.size());
  Head head{{}, key, bytes.size(), sum.value(), sizeof(Head) + bytes.size() + arrays.size()};
  std::memcpy(head.magic, kMagic, sizeof kMagic);
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&head), sizeof head);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  arrays.write(file);
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (file && !error) return Done{};
  std::filesystem::remove(part, error);
  return Error{ErrorCode::kIo, "the terrain cannot be written", path};
}

Result<Terrain> read_terrain_file(const std::string& path, std::uint64_t key) {
  auto opened = MappedFile::open(path);
  if (!opened) return Error{ErrorCode::kIo, "no such terrain file", path};
  const std::span<const char> bytes = (*opened)->bytes();
  Head head{};
  if (bytes.size() < sizeof head) return data_error("is no terrain file", path);
  std::memcpy(&head, bytes.data(), sizeof head);
  if (std::memcmp(head.magic, kMagic, sizeof kMagic) != 0) return data_error("is no terrain file", path);
  if (head.key != key) return data_error("is the terrain of another network, elevation or options", path);
  const auto damaged = [&] { return data_error("the terrain file is damaged", path); };
  if (head.file_bytes != bytes.size() || head.table_bytes > bytes.size() - sizeof head) return damaged();
  const std::span<const char> table_bytes = bytes.subspan(sizeof head, head.table_bytes);
  Hash sum;
  sum.add(table_bytes.data(), table_bytes.size());
  if (sum.value() != head.table_sum) return damaged();
  Table table;
  Reader reader(table_bytes);
  exchange(reader, table);
  if (!reader.good()) return damaged();
  const auto ground = InFile::of(*opened, sizeof head + head.table_bytes, std::move(table));
  if (!ground) return damaged();

  auto impl = std::make_unique<Terrain::Impl>();
  const Table& t = ground->table();
  impl->report = t.report;
  impl->unit_m = t.unit_m;
  impl->origin_m = t.origin_m;
  impl->k = t.k;
  impl->tile_count = t.tile_count;
  impl->hollows = t.hollows;
  impl->halls = t.halls;
  impl->index_hollows();
  impl->heights =
      HeightMesh(t.tile_count, t.k, kQuantum_m, ground->at(t.height_nodes), ground->at(t.height_leaves), *opened);
  if (checksum(impl->heights) != t.heights_sum || !impl->heights.is_sound()) return damaged();
  for (std::size_t i = 0; i < ground->tiles().size(); ++i) {
    if (!ground->load(i, 0, static_cast<std::uint32_t>(ground->tiles()[i].bands.size()))) return damaged();
    ground->release(i);
  }
  impl->stored = ground;
  return Terrain(std::move(impl));
}

}  // namespace roadgen
