// Heights of OSM ways: level at 0 but where bridges and tunnels cross other ways. Internal to roadgen/import.
#pragma once

#include <vector>

#include "roadgen/import/osm_course.h"

namespace roadgen {

// Heights at distances along a line, increasing; between them a monotone cubic, level beyond them. Empty: 0.
struct HeightProfile {
  std::vector<double> at_m, z_m;

  struct Value {
    double z_m = 0, grade = 0;
  };
  Value value(double distance_m) const;
};

}  // namespace roadgen
