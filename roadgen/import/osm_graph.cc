#include "roadgen/import/osm_graph.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "roadgen/import/clean.h"

namespace roadgen {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

class GraphMaker {
 public:
  GraphMaker(const OsmData& data, const std::vector<glm::dvec2>& positions_m, ElementFindings& findings)
      : data_(data), positions_m_(positions_m), findings_(findings) {}
  OsmGraph run();

 private:
  void count_arms();
  void cut_ways();
  void find_reversals();
  void join_pieces();
  void follow(std::uint32_t start_end);
  void take_line(std::uint32_t first_piece, bool closed);
  void collect_ends();
  std::uint32_t node_at(std::uint32_t piece_end) const {
    const OsmPiece& p = cut_[piece_end / 2];
    return data_.refs[piece_end % 2 == 0 ? p.first : p.last];
  }
  // The end of another piece that the line goes on with, or kNone.
  std::uint32_t partner(std::uint32_t piece_end) const;
  bool turns_back(std::uint32_t before, std::uint32_t node, std::uint32_t after) const;
  std::string node_name(std::uint32_t node) const { return "node " + std::to_string(data_.node_ids[node]); }

  const OsmData& data_;
  const std::vector<glm::dvec2>& positions_m_;
  ElementFindings& findings_;
  OsmGraph graph_;
  std::vector<std::uint8_t> arms_;   // of each node, 255 at most
  std::vector<char> ends_here_;      // nodes where lines end though only two arms meet
  std::vector<OsmPiece> cut_;        // ways cut at junctions, along them
  std::vector<std::uint32_t> link_;  // of each piece's end: the other end at its node where there are two
  std::vector<char> used_;           // of each piece
};

void GraphMaker::count_arms() {
  arms_.assign(data_.node_ids.size(), 0);
  const auto add = [&](std::uint32_t node, int n) {
    arms_[node] = static_cast<std::uint8_t>(std::min(arms_[node] + n, 255));
  };
  for (const OsmWay& way : data_.ways) {
    for (std::uint32_t i = 0; i < way.count; ++i) {
      add(data_.refs[way.first + i], i == 0 || i + 1 == way.count ? 1 : 2);
    }
  }
}

bool GraphMaker::turns_back(std::uint32_t before, std::uint32_t node, std::uint32_t after) const {
  const glm::dvec2 in = positions_m_[node] - positions_m_[before], out = positions_m_[after] - positions_m_[node];
  const double turn = std::atan2(in.x * out.y - in.y * out.x, glm::dot(in, out));
  return std::abs(turn) > kReversal_rad;
}

// Within ways; between ways partner() looks.
void GraphMaker::find_reversals() {
  ends_here_.assign(data_.node_ids.size(), 0);
  for (const OsmWay& way : data_.ways) {
    for (std::uint32_t i = 1; i + 1 < way.count; ++i) {
      const std::uint32_t* at = &data_.refs[way.first + i];
      if (arms_[*at] > 2 || !turns_back(at[-1], *at, at[1])) continue;
      ends_here_[*at] = 1;
      findings_.add(Severity::kWarning, "ways that turn back", "way " + std::to_string(way.id),
                    "turns back on the spot at " + node_name(*at) + ": ends there");
    }
  }
}

void GraphMaker::cut_ways() {
  for (std::size_t w = 0; w < data_.ways.size(); ++w) {
    const OsmWay& way = data_.ways[w];
    std::uint32_t begin = way.first;
    for (std::uint32_t i = way.first + 1; i < way.first + way.count; ++i) {
      const std::uint32_t node = data_.refs[i];
      if (i + 1 < way.first + way.count && arms_[node] <= 2 && !ends_here_[node]) continue;
      cut_.push_back({static_cast<std::uint32_t>(w), begin, i});
      begin = i;
    }
  }
}

void GraphMaker::join_pieces() {
  // The ends at each node of two arms know one another.
  link_.assign(2 * cut_.size(), kNone);
  std::vector<std::uint32_t> waiting(data_.node_ids.size(), kNone);
  for (std::uint32_t end = 0; end < link_.size(); ++end) {
    const std::uint32_t node = node_at(end);
    if (arms_[node] != 2 || ends_here_[node]) continue;
    if (waiting[node] == kNone) {
      waiting[node] = end;
    } else {
      link_[end] = waiting[node];
      link_[waiting[node]] = end;
    }
  }
  used_.assign(cut_.size(), 0);
  // Lines with ends, then loops.
  for (const bool loops : {false, true}) {
    for (std::uint32_t end = 0; end < link_.size(); ++end) {
      if (!used_[end / 2] && (loops || partner(end) == kNone)) follow(end);
    }
  }
}

std::uint32_t GraphMaker::partner(std::uint32_t piece_end) const {
  const std::uint32_t other = link_[piece_end];
  if (other == kNone) return kNone;
  const auto next_to = [&](std::uint32_t end) {
    const OsmPiece& p = cut_[end / 2];
    return data_.refs[end % 2 == 0 ? p.first + 1 : p.last - 1];
  };
  return turns_back(next_to(piece_end), node_at(piece_end), next_to(other)) ? kNone : other;
}

// The line that begins with the given end of a piece.
void GraphMaker::follow(std::uint32_t start_end) {
  const auto first = static_cast<std::uint32_t>(graph_.pieces.size());
  bool closed = false;
  for (std::uint32_t end = start_end; end != kNone;) {
    OsmPiece piece = cut_[end / 2];
    used_[end / 2] = 1;
    if (end % 2 == 1) std::swap(piece.first, piece.last);
    graph_.pieces.push_back(piece);
    end = partner(end ^ 1u);
    if (end == start_end) closed = true;
    if (end != kNone && used_[end / 2]) break;
  }
  take_line(first, closed);
}

void GraphMaker::take_line(std::uint32_t first_piece, bool closed) {
  const auto begin = graph_.pieces.begin() + first_piece;
  const auto directed =
      std::find_if(begin, graph_.pieces.end(), [&](const OsmPiece& p) { return data_.ways[p.way].tags.oneway(); });
  if (directed != graph_.pieces.end() && !directed->along()) {
    std::reverse(begin, graph_.pieces.end());
    for (auto piece = begin; piece != graph_.pieces.end(); ++piece) std::swap(piece->first, piece->last);
  }
  OsmLine line;
  line.first_piece = first_piece;
  line.pieces = static_cast<std::uint32_t>(graph_.pieces.size()) - first_piece;
  line.node_start = data_.refs[begin->first];
  line.node_end = data_.refs[graph_.pieces.back().last];
  line.closed = closed;
  graph_.lines.push_back(line);
}

void GraphMaker::collect_ends() {
  std::vector<std::pair<std::uint32_t, LineEnd>> all;
  for (std::size_t i = 0; i < graph_.lines.size(); ++i) {
    const OsmLine& line = graph_.lines[i];
    if (line.closed) continue;
    if (arms_[line.node_start] > 2) all.emplace_back(line.node_start, static_cast<LineEnd>(2 * i));
    if (arms_[line.node_end] > 2) all.emplace_back(line.node_end, static_cast<LineEnd>(2 * i + 1));
  }
  std::sort(all.begin(), all.end());
  for (const auto& [node, end] : all) {
    if (graph_.nodes.empty() || graph_.nodes.back() != node) {
      graph_.nodes.push_back(node);
      graph_.first_end.push_back(static_cast<std::uint32_t>(graph_.ends.size()));
    }
    graph_.ends.push_back(end);
  }
  graph_.first_end.push_back(static_cast<std::uint32_t>(graph_.ends.size()));
}

OsmGraph GraphMaker::run() {
  count_arms();
  find_reversals();
  cut_ways();
  join_pieces();
  collect_ends();
  return std::move(graph_);
}

}  // namespace

OsmGraph make_graph(const OsmData& data, const std::vector<glm::dvec2>& positions_m, ElementFindings& findings) {
  return GraphMaker(data, positions_m, findings).run();
}

void nodes_of(const OsmGraph& graph, const OsmData& data, const OsmLine& line, std::vector<std::uint32_t>& nodes) {
  nodes.clear();
  for (const OsmPiece& piece : graph.pieces_of(line)) {
    if (nodes.empty()) nodes.push_back(data.refs[piece.first]);
    for (std::uint32_t i = 1; i <= piece.legs(); ++i) {
      nodes.push_back(data.refs[piece.along() ? piece.first + i : piece.first - i]);
    }
  }
}

}  // namespace roadgen
