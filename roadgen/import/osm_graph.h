// Lines between the junctions of OSM ways. Internal to roadgen/import.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/import/osm_file.h"

namespace roadgen {

// A stretch of a way between two places where lines or ways end: positions first to last of OsmData::refs, backward
// where first > last.
struct OsmPiece {
  std::uint32_t way = 0;
  std::uint32_t first = 0, last = 0;
  bool along() const { return first < last; }
  std::uint32_t legs() const { return along() ? last - first : first - last; }
};

// Pieces one after the other, through nodes where nothing else meets: from a junction or dead end to another.
struct OsmLine {
  std::uint32_t first_piece = 0, pieces = 0;  // of OsmGraph::pieces
  std::uint32_t node_start = 0, node_end = 0;
  bool closed = false;  // a loop that nothing meets: the last point is the first one
};

// The end of a line: 2 * line for its start, 2 * line + 1 for its end.
using LineEnd = std::uint32_t;
inline std::size_t line_of(LineEnd end) { return end / 2; }
inline bool is_at_end(LineEnd end) { return end % 2 == 1; }

struct OsmGraph {
  std::vector<OsmPiece> pieces;
  std::vector<OsmLine> lines;
  // Nodes where three or more lines' ends meet; ends of node k: ends[first_end[k]] to ends[first_end[k + 1]].
  std::vector<std::uint32_t> nodes;
  std::vector<std::uint32_t> first_end;
  std::vector<LineEnd> ends;

  std::span<const OsmPiece> pieces_of(const OsmLine& line) const {
    return std::span(pieces).subspan(line.first_piece, line.pieces);
  }
};

// Lines run as their first way of one direction does, if they have any. A line ends too where it turns by more than
// kReversal_rad on the spot, with a finding. Cost: O(n log n) in the number of nodes.
OsmGraph make_graph(const OsmData& data, const std::vector<glm::dvec2>& positions_m, ElementFindings& findings);

// The node at each point of a line, pieces one after the other.
void nodes_of(const OsmGraph& graph, const OsmData& data, const OsmLine& line, std::vector<std::uint32_t>& nodes);

}  // namespace roadgen
