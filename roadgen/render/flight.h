// Cameras that follow a road: on it, as a driver sees it, and above it, as a fly-through.
#pragma once

#include "roadgen/render/camera.h"
#include "roadgen/road/network.h"

namespace roadgen {

// The driver's view: at (s, t), height_m above the surface, looking along the road with its heading and pitch.
Camera drive_camera(const Road& road, double s_m, double t_m, double height_m);

struct FlightOptions {
  double height_m = 22;  // above the smoothed road
  double smooth_m = 90;  // the path is the road's mean over this length to both sides. >= 0
  double ahead_m = 170;  // where the view points, along the road
};

// The camera of a flight along the road at arc length s_m: above the road's mean course, looking at where it goes.
// Continuous in s; beyond the ends of an open road the view keeps its direction. Requires: a segment at least.
Camera flight_camera(const Road& road, double s_m, const FlightOptions& options);

}  // namespace roadgen
