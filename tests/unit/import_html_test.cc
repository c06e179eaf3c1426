// The page of an import: well formed whatever names it holds, and its numbers are the certificate's.
#include "roadgen/import/html_report.h"

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <pugixml.hpp>

#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

// A wavy road of 2 km with points every 20 m and heights, off it by up to 4 cm.
ImportResult wavy(const test::TemporaryFolder& folder) {
  std::string csv = "x,y,height\n";
  for (int i = 0; i <= 100; ++i) {
    const double x = 20.0 * i;
    csv += fmt::format("{},{},{}\n", x, 60 * std::sin(x / 150) + 0.04 * std::sin(7.0 * i), 300 + 0.03 * x);
  }
  auto result = import_files({folder.put("wavy.csv", csv)}, {});
  EXPECT_TRUE(result.ok()) << result.error().text();
  return std::move(*result);
}

// The page without its first line, which is HTML's own.
pugi::xml_document parsed(const std::string& page) {
  pugi::xml_document document;
  const auto outcome = document.load_string(page.c_str() + page.find('\n'));
  EXPECT_TRUE(outcome) << outcome.description() << " at " << outcome.offset;
  return document;
}

TEST(ImportHtml, ShowsTheCertificateAndEveryPoint) {
  const test::TemporaryFolder folder;
  const ImportResult result = wavy(folder);
  const pugi::xml_document page = parsed(import_html(result));
  const auto body = page.child("html").child("body");
  const Certificate& c = result.certificates[0];
  const auto row = body.child("table").first_child().next_sibling();
  std::vector<std::string> cells;
  for (const auto& cell : row.children("td")) cells.push_back(cell.child_value());
  ASSERT_EQ(cells.size(), 15u);
  EXPECT_EQ(cells[3], fmt::format("{:.2f}", c.length_m));
  EXPECT_EQ(cells[4], "101");
  EXPECT_EQ(cells[5], std::to_string(c.segments));
  EXPECT_EQ(cells[7], fmt::format("{:.4f}", c.max_error_m));
  EXPECT_EQ(cells[10], fmt::format("{:.4f}", c.bound_m));

  // Plan, then three plots: errors, curvature, elevation.
  std::vector<pugi::xml_node> pictures;
  for (const auto& svg : body.children("svg")) pictures.push_back(svg);
  ASSERT_EQ(pictures.size(), 4u);
  std::size_t paths = 0;
  for ([[maybe_unused]] const auto& path : pictures[0].child("g").children("path")) ++paths;
  EXPECT_EQ(paths, c.segments);
  // Every point lies between the dashed lines of the allowed error, and the farthest where the certificate has it.
  std::vector<double> limits;
  for (const auto& line : pictures[1].children("line")) {
    if (std::string(line.attribute("class").value()) == "limit") limits.push_back(line.attribute("y1").as_double());
  }
  ASSERT_EQ(limits.size(), 2u);
  const double middle = 0.5 * (limits[0] + limits[1]), reach = std::abs(limits[0] - limits[1]) / 2;
  double most = 0;
  std::size_t points = 0;
  for (const auto& dot : pictures[1].child("g").children("circle")) {
    most = std::max(most, std::abs(dot.attribute("cy").as_double() - middle) / reach * result.allowed_error_m[0]);
    ++points;
  }
  EXPECT_EQ(points, 101u);
  EXPECT_NEAR(most, c.max_error_m, 0.2 / reach * result.allowed_error_m[0]);  // coordinates of 0.1
}

TEST(ImportHtml, NamesAreText) {
  const test::TemporaryFolder folder;
  ImportResult result = wavy(folder);
  result.network.roads[0].name = "<script>alert('&\"')</script>\x01";
  result.diagnostics.push_back({Severity::kWarning, "a < b & \"c\"", "</li>", 3, "<p>"});
  const std::string page = import_html(result);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  const pugi::xml_document document = parsed(page);
  EXPECT_FALSE(document.child("html").child("body").find_node([](const pugi::xml_node& n) { return std::string(n.name()) == "script"; }));
}

TEST(ImportHtml, ManyRoadsDoNotMakeItEndless) {
  const test::TemporaryFolder folder;
  ImportResult result = wavy(folder);
  for (int i = 1; i < 3000; ++i) {
    result.network.roads.push_back(result.network.roads[0]);
    result.certificates.push_back(result.certificates[0]);
    result.allowed_error_m.push_back(result.allowed_error_m[0]);
    result.samples.push_back(result.samples[0]);
  }
  const std::string page = import_html(result);
  std::size_t plots = 0;
  for (std::size_t at = page.find("<h2>Road"); at != page.npos; at = page.find("<h2>Road", at + 1)) ++plots;
  EXPECT_EQ(plots, kMostPlottedRoads);
  EXPECT_NE(page.find("2000 more roads are left out"), std::string::npos);
  EXPECT_LT(page.size(), 8u << 20);
}

}  // namespace
}  // namespace roadgen
