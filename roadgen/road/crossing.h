// Joins the ends of roads in a junction: its area between the carriageways, and along its corners what lies beside them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "roadgen/road/network.h"

namespace roadgen {

// For every road of the network whether add_crossing made it for the corner of a junction that has an area. Cost:
// O(n log n).
std::vector<bool> corner_roads(const Network& network);

struct RoadEnd {
  std::string road;     // id
  bool at_end = false;  // the road's end, otherwise its start
};

// The edges of a road's carriageway, as t: the lanes about the reference line as far as the first kerb, sidewalk, verge
// or raised lane; where these lie at the reference line itself, the widest lanes without one between them that are driven.
struct Carriageway {
  double left_m, right_m;
};
Carriageway carriageway_at(const Road& road, const Segment& segment, double local_s_m);

// How a road's end meets a junction.
JunctionArm arm_of(const Road& road, bool at_end);

// A junction and the roads along its corners.
struct Crossing {
  Junction junction;
  std::vector<Road> corners;
  std::vector<std::size_t> bare;  // corners too tight for what lies beside them, which is left out
};
struct EndOfRoad {
  const Road* road = nullptr;
  bool at_end = false;
};

// The junction `id` that the given ends form, and for every corner beside which both arms have kerbs, sidewalks or verges
// a road "ID.corner.N" that carries them around: strips of one type are joined, others taper away. None where no mapping
// can be certified: bent too tightly for the strips' width, or a strip of hardly any width.
// Requires: roads with segments, not closed. Diagnostics and errors: as make_junction.
Result<Crossing> make_crossing(const std::string& id, std::span<const EndOfRoad> ends,
                               const JunctionOptions& options = {}, Diagnostics* diagnostics = nullptr);

// A crossing that is to be: of the given ends.
struct CrossingPlan {
  std::string id;
  std::vector<RoadEnd> ends;
  JunctionOptions options = {};
};

// Adds to the network the junctions that the given ends of its roads form, and the roads along their corners (see
// make_crossing). Ends in a junction are marked as joined, so markings and surfaces end at its cut, and linked to it.
// Diagnostics: as make_junction. Errors, one status a plan: as make_junction; kGeometry for an end of a road that the
// network lacks or that is closed, or where a corner's road has the id of another. Nothing is changed for such a plan.
// Cost: O(roads + plans).
std::vector<Status> add_crossings(Network& network, std::span<const CrossingPlan> plans,
                                  Diagnostics* diagnostics = nullptr);

// One of them. Cost: O(roads); where there are many, add_crossings is for them.
Status add_crossing(Network& network, std::string id, const std::vector<RoadEnd>& ends,
                    const JunctionOptions& options = {}, Diagnostics* diagnostics = nullptr);

}  // namespace roadgen
