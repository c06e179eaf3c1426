#include <algorithm>
#include <array>

#include "roadgen/fit/heights.h"

namespace roadgen {
namespace {

struct ClassLimits {
  const char* name;
  HeightLimits limits;
};
constexpr std::array<ClassLimits, 18> kClasses = {{
    {"motorway", {0.06, 1.0 / 3000}},
    {"motorway_link", {0.08, 1.0 / 750}},
    {"trunk", {0.08, 1.0 / 1500}},
    {"trunk_link", {0.1, 1.0 / 400}},
    {"primary", {0.15, 1.0 / 250}},
    {"primary_link", {0.15, 1.0 / 200}},
    {"secondary", {0.15, 1.0 / 200}},
    {"secondary_link", {0.15, 1.0 / 150}},
    {"tertiary", {0.18, 1.0 / 150}},
    {"tertiary_link", {0.18, 1.0 / 100}},
    {"unclassified", {0.2, 1.0 / 100}},
    {"residential", {0.2, 1.0 / 75}},
    {"living_street", {0.22, 1.0 / 50}},
    {"service", {0.22, 1.0 / 50}},
    {"track", {0.25, 1.0 / 50}},
    {"road", {0.18, 1.0 / 150}},
    {"busway", {0.15, 1.0 / 200}},
    {"raceway", {0.2, 1.0 / 250}},
}};

}  // namespace

HeightLimits height_limits(std::string_view road_class) {
  const auto found =
      std::find_if(kClasses.begin(), kClasses.end(), [&](const ClassLimits& c) { return c.name == road_class; });
  return found == kClasses.end() ? HeightLimits{} : found->limits;
}

}  // namespace roadgen
