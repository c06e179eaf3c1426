// The ground before any road was built, as a grid in the network's plane: from a digital elevation model, or, where
// there is none, from the heights of the roads themselves.
#pragma once

#include <functional>
#include <optional>

#include <glm/vec2.hpp>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"
#include "terrain/elevation.h"
#include "terrain/grid.h"

namespace roadgen {

// A rectangle of the network's plane.
struct Rectangle {
  glm::dvec2 low_m{0, 0}, high_m{0, 0};
};

// Done where the model reaches under every road. Errors (kData): the model does not, stating both extents in degrees;
// the model is in longitude and latitude and the network has no georeference; the other way round.
Status check_coverage(const Elevation& elevation, const Network& network);

// The part of the plane that the model covers (the greatest rectangle inside its four sides).
// Requires: check_coverage passed.
Rectangle covered_rectangle(const Elevation& elevation, const Network& network);

// The model's height at a place of the network's plane, as z of the network's frame. The Earth is round: the place on
// the ellipsoid is the one whose east and north are the given ones when it is lifted to its own height.
// Accuracy: 0.1 mm plus the interpolation. Requires: check_coverage passed.
double elevation_enu_m(const Elevation& elevation, const Network& network, glm::dvec2 point_m);

// The same for many places, and only where the model has a height of its own: none in filled voids or outside of it.
// The function refers to both arguments. Requires: check_coverage passed.
std::function<std::optional<double>(glm::dvec2 point_m)> measured_ground(const Elevation& elevation,
                                                                         const Network& network);

// Heights of the whole rectangle, a post at most every spacing_m; the grid covers the rectangle exactly.
// Requires: check_coverage passed; low < high. Cost: about 1 us a post.
Grid natural_from_elevation(const Elevation& elevation, const Network& network, const Rectangle& area,
                            double spacing_m);

// The same without a model: a membrane through the roads' heights, but for those of bridges and tunnels unless
// there are no others, with rolling hills of about rolling_m height that
// fade in with the distance from the roads. Deterministic. Requires: at least one segment; low < high.
Grid natural_from_roads(const Network& network, const Rectangle& area, double spacing_m, double rolling_m);

}  // namespace roadgen
