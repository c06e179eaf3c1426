#include "tests/bench/plot.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace roadgen::bench {
namespace {

constexpr double kWidth = 900, kHeight = 560, kLeft = 80, kRight = 260, kTop = 44, kBottom = 60;
const char* const kColors[] = {"#d62728", "#1f4e8c", "#2a7ab8", "#5ba3cf", "#8cc0a0",
                               "#b5a642", "#7a5195", "#777777", "#e08214", "#111111"};

// A logarithmic axis from pixel a to pixel b.
struct Axis {
  double low = 1e300, high = 0, a, b;
  void add(double x) { low = std::min(low, x), high = std::max(high, x); }
  double at(double x) const { return a + (b - a) * std::log(x / low) / std::log(high / low); }
  // 1, 2, 5, 10, ... within the range.
  std::vector<double> ticks() const {
    std::vector<double> list;
    for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high; decade *= 10) {
      for (const double m : {1.0, 2.0, 5.0}) {
        if (m * decade >= low * 0.999 && m * decade <= high * 1.001) list.push_back(m * decade);
      }
    }
    return list;
  }
};

}  // namespace

std::string log_log_svg(const std::string& title, const std::string& x_label, const std::string& y_label,
                        const std::vector<Curve>& curves) {
  Axis x{.a = kLeft, .b = kWidth - kRight}, y{.a = kHeight - kBottom, .b = kTop};
  for (const Curve& curve : curves) {
    for (const double v : curve.x) x.add(v);
    for (const double v : curve.y) y.add(v);
  }
  x.high = std::max(x.high, 2 * x.low);
  y.low *= 0.9, y.high *= 1.1;
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" font-family="sans-serif" font-size="13">
<rect width="{0}" height="{1}" fill="white"/>
<text x="{2}" y="26" font-size="15">{3}</text>
)",
      kWidth, kHeight, kLeft, title);
  for (const double tick : x.ticks()) {
    svg += fmt::format(
        R"(<path d="M{0:.1f} {1} V{2}" stroke="#ddd"/><text x="{0:.1f}" y="{3}" text-anchor="middle">{4:g}</text>
)",
        x.at(tick), y.a, y.b, y.a + 18, tick);
  }
  for (const double tick : y.ticks()) {
    svg += fmt::format(
        R"(<path d="M{1} {0:.1f} H{2}" stroke="#ddd"/><text x="{3}" y="{5:.1f}" text-anchor="end">{4:g}</text>
)",
        y.at(tick), x.a, x.b, x.a - 8, tick, y.at(tick) + 4);
  }
  svg += fmt::format(R"(<text x="{}" y="{}" text-anchor="middle">{}</text>
<text transform="translate(22 {}) rotate(-90) " text-anchor="middle">{}</text>
)",
                     (x.a + x.b) / 2, kHeight - 14, x_label, (y.a + y.b) / 2, y_label);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Curve& curve = curves[i];
    // "name, variant" has the colour of "name".
    const std::string base = curve.name.substr(0, curve.name.find(", "));
    const auto partner = std::find_if(curves.begin(), curves.end(), [&](const Curve& c) { return c.name == base; });
    const auto index = partner == curves.end() ? i : static_cast<std::size_t>(partner - curves.begin());
    const char* color = kColors[index % std::size(kColors)];
    const char* dash = curve.dashed ? R"( stroke-dasharray="6 4")" : "";
    std::string points;
    for (std::size_t k = 0; k < curve.x.size(); ++k)
      points += fmt::format("{:.1f},{:.1f} ", x.at(curve.x[k]), y.at(curve.y[k]));
    const double row = kTop + 14 + 22 * static_cast<double>(i);
    svg += fmt::format(
        R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="2"{}/>
<path d="M{} {} h28" stroke="{}" stroke-width="2"{}/><text x="{}" y="{}">{}</text>
)",
        points, color, dash, x.b + 16, row, color, dash, x.b + 52, row + 4, curve.name);
  }
  return svg + "</svg>\n";
}

}  // namespace roadgen::bench
