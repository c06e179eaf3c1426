#include "tests/common/osm_city.h"

#include <cmath>
#include <vector>

#include <osmium/builder/attr.hpp>
#include <osmium/io/any_output.hpp>
#include <osmium/memory/buffer.hpp>

namespace roadgen::test {
namespace {

constexpr std::size_t kBufferSize = 1 << 20;
constexpr double kBlockLatitude_deg = 0.0009, kBlockLongitude_deg = 0.00134;  // 100 m at 48 degrees

class CityWriter {
 public:
  CityWriter(const std::string& path, std::size_t blocks)
      : writer_(osmium::io::File(path), osmium::io::overwrite::allow), blocks_(blocks) {}

  std::size_t run() {
    using namespace osmium::builder::attr;
    for (std::size_t i = 0; i <= blocks_; ++i) {
      for (std::size_t j = 0; j <= blocks_; ++j) {
        const auto along = static_cast<double>(j) * kBlockLongitude_deg,
                   up = static_cast<double>(i) * kBlockLatitude_deg;
        osmium::builder::add_node(buffer_, _id(node(i, j)), _version(1), _location(11 + along, 48 + up));
        flush(false);
      }
    }
    for (std::size_t street = 0; street <= blocks_; ++street) {
      for (std::size_t at = 0; at + 2 <= blocks_; at += 2) way(street, at, true);
    }
    for (std::size_t street = 0; street <= blocks_; ++street) {
      for (std::size_t at = 0; at + 2 <= blocks_; at += 2) way(street, at, false);
    }
    flush(true);
    writer_.close();
    return ways_;
  }

 private:
  osmium::object_id_type node(std::size_t i, std::size_t j) const {
    return static_cast<osmium::object_id_type>(1 + i * (blocks_ + 1) + j);
  }
  void way(std::size_t street, std::size_t at, bool east) {
    using namespace osmium::builder::attr;
    std::vector<osmium::object_id_type> nodes;
    for (std::size_t k = 0; k <= 2; ++k) nodes.push_back(east ? node(street, at + k) : node(at + k, street));
    const char* highway = street % 10 == 0   ? "primary"
                          : street % 10 == 5 ? "secondary"
                          : street % 10 == 3 ? "tertiary"
                                             : "residential";
    const std::string name = (east ? "Street " : "Avenue ") + std::to_string(street);
    osmium::builder::add_way(buffer_, _id(static_cast<osmium::object_id_type>(++ways_)), _version(1), _nodes(nodes),
                             _tag("highway", highway), _tag("name", name));
    flush(false);
  }
  void flush(bool all) {
    if (!all && buffer_.committed() < kBufferSize / 2) return;
    writer_(std::move(buffer_));
    buffer_ = osmium::memory::Buffer(kBufferSize, osmium::memory::Buffer::auto_grow::yes);
  }

  osmium::memory::Buffer buffer_{kBufferSize, osmium::memory::Buffer::auto_grow::yes};
  osmium::io::Writer writer_;
  std::size_t blocks_, ways_ = 0;
};

}  // namespace

std::size_t write_osm_city(const std::string& path, std::size_t ways) {
  // Of b blocks a side there are about b ways a direction and street, halved.
  return CityWriter(path, static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(ways))))).run();
}

}  // namespace roadgen::test
