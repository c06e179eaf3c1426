#include "terrain/terrain_file.h"

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <type_traits>

#include "terrain/terrain_impl.h"

namespace roadgen {
namespace {

constexpr char kMagic[8] = {'r', 'o', 'a', 'd', 'g', 'n', 'd', '2'};  // the last: of the format

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
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_;
};

// Requires bytes whose checksum is right: what is asked for is there. Lengths are checked nevertheless.
class Reader {
 public:
  explicit Reader(const std::vector<char>& bytes) : bytes_(bytes) {}
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
  bool good() const { return !failed_ && at_ == bytes_.size(); }

 private:
  void take(void* to, std::size_t count) {
    if (failed_ || count > bytes_.size() - at_) {
      failed_ = true;
      return;
    }
    if (count > 0) std::memcpy(to, bytes_.data() + at_, count);
    at_ += count;
  }
  const std::vector<char>& bytes_;
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

template <class Archive, class Tile>
requires std::is_same_v<std::remove_const_t<Tile>, TerrainMesh>
void exchange(Archive& with, Tile& tile) {
  with(tile.origin_m);
  with(tile.positions_m);
  with(tile.normals);
  with(tile.road_m);
  with(tile.triangles);
  with(tile.cuts);
  with(tile.hollows);
  with(tile.nodes);
  with(tile.roots);
  with(tile.error_m);
  with(tile.radius_m);
}

template <class Archive, class Impl, class Kept>
void exchange_all(Archive& with, Impl& impl, Kept& mesh) {
  with(impl.report);
  with(impl.tiles);
  with(impl.unit_m);
  with(impl.origin_m);
  with(impl.k);
  with(impl.tile_count);
  with(impl.hollows);
  with(mesh.triangles);
  with(mesh.child);
  with(mesh.lattice);
  with(mesh.heights);
}

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

// Magic, key, checksum, then all the rest.
Status write_terrain_file(const Terrain& terrain, std::uint64_t key, const std::string& path) {
  const Terrain::Impl& impl = *terrain.impl_;
  Writer writer;
  const Bisection::Kept mesh = impl.mesh->kept();
  exchange_all(writer, impl, mesh);
  Hash checksum;
  checksum.add(writer.bytes().data(), writer.bytes().size());
  const std::uint64_t sum = checksum.value();
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(kMagic, sizeof kMagic);
  file.write(reinterpret_cast<const char*>(&key), sizeof key);
  file.write(reinterpret_cast<const char*>(&sum), sizeof sum);
  file.write(writer.bytes().data(), static_cast<std::streamsize>(writer.bytes().size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (file && !error) return Done{};
  std::filesystem::remove(part, error);
  return Error{ErrorCode::kIo, "the terrain cannot be written", path};
}

Result<Terrain> read_terrain_file(const std::string& path, std::uint64_t key) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return Error{ErrorCode::kIo, "no such terrain file", path};
  const std::streamoff size = file.tellg();
  constexpr std::streamoff kHead = sizeof kMagic + 16;
  if (size < kHead) return data_error("is no terrain file", path);
  file.seekg(0);
  char magic[sizeof kMagic];
  std::uint64_t has_key = 0, sum = 0;
  file.read(magic, sizeof magic);
  file.read(reinterpret_cast<char*>(&has_key), sizeof has_key);
  file.read(reinterpret_cast<char*>(&sum), sizeof sum);
  if (!file || std::memcmp(magic, kMagic, sizeof kMagic) != 0) return data_error("is no terrain file", path);
  if (has_key != key) return data_error("is the terrain of another network, elevation or options", path);
  std::vector<char> bytes(static_cast<std::size_t>(size - kHead));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  Hash checksum;
  checksum.add(bytes.data(), bytes.size());
  if (!file || checksum.value() != sum) return data_error("the terrain file is damaged", path);
  auto impl = std::make_unique<Terrain::Impl>();
  Bisection::Kept mesh;
  Reader reader(bytes);
  exchange_all(reader, *impl, mesh);
  if (!reader.good()) return data_error("the terrain file is damaged", path);
  impl->mesh = std::make_unique<Bisection>(impl->tile_count, impl->k, std::move(mesh));
  impl->index_hollows();
  return Terrain(std::move(impl));
}

}  // namespace roadgen
