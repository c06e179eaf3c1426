// A picture of curves, as SVG text.
#pragma once

#include <string>
#include <vector>

namespace roadgen::bench {

struct Curve {
  std::string name;
  std::vector<double> x, y;  // > 0
  bool dashed = false;
};

// Both axes logarithmic, with a line at every power of ten and half a decade between. Requires: a point at least.
std::string log_log_svg(const std::string& title, const std::string& x_label, const std::string& y_label,
                        const std::vector<Curve>& curves);

}  // namespace roadgen::bench
