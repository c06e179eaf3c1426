#include "roadgen/export/xodr_objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roadgen/export/xodr_records.h"

namespace roadgen {
namespace {

struct ObjectType {
  const char *type, *subtype;
};
// In the order of PaintKind.
constexpr ObjectType kPaint[] = {{"roadMark", "signalLines"},       {"crosswalk", "zebra"},
                                 {"roadMark", "arrowStraight"},     {"roadMark", "arrowLeft"},
                                 {"roadMark", "arrowRight"},        {"roadMark", "arrowStraightLeft"},
                                 {"roadMark", "arrowStraightRight"}};

void write_paint(XmlWriter& out, const Road& road, std::size_t index) {
  const Paint& paint = road.paint[index];
  const ObjectType& object = kPaint[static_cast<std::size_t>(paint.kind)];
  out.raw("      <object").text("id", road.id + "-" + std::to_string(index + 1)).text("type", object.type);
  out.text("subtype", object.subtype).number("s", paint.s_m).number("t", paint.t_m).raw(" zOffset=\"0\"");
  out.number("hdg", paint.against ? std::numbers::pi : 0).raw(" pitch=\"0\" roll=\"0\"");
  out.text("orientation", paint.against ? "-" : "+").number("length", paint.length_m);
  out.number("width", paint.width_m).raw(" height=\"0\">\n");
  out.user_data("        ", "paint", {static_cast<double>(paint.color), paint.stripe_m});
  out.raw("      </object>\n");
}

// The box that a sweep of constant cross section fills, as the standard has it.
struct Envelope {
  const char *type, *subtype;
  double low_m, height_m, width_m;
};
Envelope envelope(const Tunnel& x) {
  return {"tunnel", "standard", 0, x.wall_height_m + x.arch_rise_m, 2 * x.half_width_m};
}
Envelope envelope(const GuardRail& x) {
  return {"barrier", "guardRail", x.top_m - x.beam_height_m, x.beam_height_m, x.beam_depth_m};
}
Envelope envelope(const Pipe& x) {
  return {"obstacle", "pipe", x.height_m - x.radius_m, 2 * x.radius_m, 2 * x.radius_m};
}
Envelope envelope(const Cable& x) {
  return {"obstacle", "cable", x.height_m - x.sag_m - x.radius_m, x.sag_m + 2 * x.radius_m, 2 * x.radius_m};
}

// userData roadgen:sweep: place among the road's sweeps, s_start, s_end, t, slope of t, the shape's numbers, and the
// albedo where it has one.
void write_exact_sweep(XmlWriter& out, const Sweep& sweep, std::size_t index) {
  std::vector<double> all = {static_cast<double>(index), sweep.s_start_m, sweep.s_end_m, sweep.t_m, sweep.t_slope};
  for (const double x : shape_numbers(sweep.shape)) all.push_back(x);
  if (sweep.albedo) all.insert(all.end(), {sweep.albedo->x, sweep.albedo->y, sweep.albedo->z});
  out.user_data("        ", "sweep", all);
}

void write_sweep(XmlWriter& out, const Road& road, std::size_t index) {
  const Sweep& sweep = road.sweeps[index];
  const Envelope box = std::visit([](const auto& shape) { return envelope(shape); }, sweep.shape);
  const bool tunnel = sweep.kind() == SweepKind::kTunnel;
  const double length = sweep.s_end_m - sweep.s_start_m;
  out.raw(tunnel ? "      <tunnel" : "      <object").text("id", road.id + "-sweep-" + std::to_string(index + 1));
  out.text("name", box.subtype).text("type", tunnel ? box.subtype : box.type).number("s", sweep.s_start_m);
  out.number("length", length);
  if (tunnel) {
    out.raw(" lighting=\"1\" daylight=\"0\">\n");
    write_exact_sweep(out, sweep, index);
    out.raw("      </tunnel>\n");
    return;
  }
  out.text("subtype", box.subtype).number("t", sweep.t_m).number("zOffset", box.low_m);
  out.raw(" hdg=\"0\" pitch=\"0\" roll=\"0\" orientation=\"none\"").number("width", box.width_m);
  out.number("height", box.height_m).raw(">\n        <repeat").number("s", sweep.s_start_m).number("length", length);
  out.raw(" distance=\"0\"").number("tStart", sweep.t_m).number("tEnd", sweep.t_m + sweep.t_slope * length);
  out.number("widthStart", box.width_m).number("widthEnd", box.width_m).number("heightStart", box.height_m);
  out.number("heightEnd", box.height_m).number("zOffsetStart", box.low_m).number("zOffsetEnd", box.low_m).raw("/>\n");
  write_exact_sweep(out, sweep, index);
  out.raw("      </object>\n");
}

}  // namespace

void write_objects(XmlWriter& out, const Road& road) {
  const RoadRecords& records = *road.records;
  if (road.paint.empty() && road.sweeps.empty() && road.bridges.empty() && records.objects.empty() &&
      records.other_objects_xml.empty()) {
    return;
  }
  out.raw("    <objects>\n");
  for (std::size_t i = 0; i < road.paint.size(); ++i) write_paint(out, road, i);
  // The schema's order: objects, references, tunnels, bridges.
  for (const bool tunnels : {false, true}) {
    if (!tunnels)
      for (const RoadObject& object : records.objects) write_object(out, object);
    if (tunnels) write_kept(out, "      ", records.other_objects_xml);
    for (std::size_t i = 0; i < road.sweeps.size(); ++i) {
      if ((road.sweeps[i].kind() == SweepKind::kTunnel) == tunnels) write_sweep(out, road, i);
    }
  }
  for (const Bridge& bridge : road.bridges) write_bridge(out, bridge);
  out.raw("    </objects>\n");
}

bool has_finite_sweeps(const Road& road) {
  return std::all_of(road.sweeps.begin(), road.sweeps.end(), [](const Sweep& sweep) {
    double sum = sweep.s_start_m + sweep.s_end_m + sweep.t_m + sweep.t_slope;
    for (const double x : shape_numbers(sweep.shape)) sum += x;
    if (sweep.albedo) sum += sweep.albedo->x + sweep.albedo->y + sweep.albedo->z;
    return std::isfinite(sum);
  });
}

}  // namespace roadgen
