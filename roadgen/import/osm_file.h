// OSM files: the ways that are driven on, and the nodes that they use. Internal to roadgen/import.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "roadgen/import/osm_tags.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Findings about single elements: of each kind the first kMostOfAKind are told, then their number, so that a broken
// planet does not fill the memory.
class ElementFindings {
 public:
  static constexpr std::size_t kMostOfAKind = 100;
  explicit ElementFindings(std::string file) : file_(std::move(file)) {}

  // kind: a string literal that names the finding, in the plural.
  void add(Severity severity, const char* kind, std::string element, std::string message);
  // What another collected, after one's own.
  void add(const ElementFindings& other);
  void append_to(Diagnostics& diagnostics) const;
  // For another part of the work on the same file.
  ElementFindings empty_copy() const { return ElementFindings(file_); }

 private:
  struct Kind {
    const char* name;
    std::size_t count = 0;
    Diagnostics told;
  };
  Kind& kind_of(const char* name);
  std::string file_;
  std::vector<Kind> kinds_;
};

struct OsmWay {
  std::int64_t id = 0;
  WayTags tags;
  std::uint32_t first = 0, count = 0;  // of OsmData::refs; at least two, no node twice in a row
};

struct OsmLocation {
  std::int32_t longitude = 0, latitude = 0;  // 1e-7 degree
};

struct OsmData {
  std::vector<OsmWay> ways;            // in the file's order; parts of a way with missing nodes share its id
  std::vector<std::uint32_t> refs;     // indices of nodes, way by way
  std::vector<std::int64_t> node_ids;  // increasing
  std::vector<OsmLocation> locations;  // of each
  std::vector<std::string> names;      // [0] is empty
};

// Whether the name's ending is one of an OSM file: .osm, .osm.gz, .osm.bz2, .osm.pbf, .pbf.
bool is_osm_file(const std::string& path);

// What memory is bounded by, however often a file repeats its elements; far more than a country has.
struct OsmLimits {
  std::size_t ways = 10'000'000;            // to drive on
  std::size_t refs = 200'000'000;           // their nodes, each as often as it stands in one
  std::size_t one_pass_nodes = 20'000'000;  // of a file read in one pass, which cannot hold so many unless it is packed
};

// Reads a large file in two passes, ways and then the nodes that they need, so memory is proportional to what is kept.
// Findings: nodes that the file lacks or whose place is not on the Earth (the way is cut there), ways of fewer than two
// nodes, ids that occur twice (the first one holds), tags that make no sense.
// Errors: kIo; kParse where the file is broken; kData where it holds no way to drive on or more than the limits.
// Cost: one parse up to 32 MB, else two; about 40 bytes of memory a node kept.
Result<OsmData> read_osm(const std::string& path, ElementFindings& findings, const OsmLimits& limits = {});

}  // namespace roadgen
