#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "roadgen/geodesy/local_frame.h"

namespace roadgen {
namespace {

TEST(LocalFrame, RoundTripIsExactToNanometres) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> latitude(-90, 90), longitude(-180, 180), metre(-50e3, 50e3);
  for (int i = 0; i < 1000; ++i) {
    const LocalFrame frame({latitude(random), longitude(random), metre(random) / 10});
    const glm::dvec3 p(metre(random), metre(random), metre(random) / 10);
    EXPECT_LT(glm::length(frame.to_local_m(frame.to_geodetic(p)) - p), 2e-8);
  }
}

TEST(LocalFrame, AxesAreEastNorthUp) {
  const LocalFrame frame({50, 11, 300});
  EXPECT_LT(glm::length(frame.to_local_m({50, 11, 300})), 1e-8);
  EXPECT_GT(frame.to_local_m({50, 11.001, 300}).x, 70);
  EXPECT_GT(frame.to_local_m({50.001, 11, 300}).y, 110);
  EXPECT_NEAR(frame.to_local_m({50, 11, 310}).z, 10, 1e-8);
}

// What the OpenDRIVE file states as its geoReference.
TEST(LocalFrame, IsTheEllipsoidalOrthographicProjectionOnTheSurface) {
  const Georeference origin{43.737, 7.426, 0};
  const LocalFrame frame(origin);
  OGRSpatialReference wgs84, ortho;
  wgs84.SetWellKnownGeogCS("WGS84");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  ASSERT_EQ(
      ortho.SetFromUserInput("+proj=ortho +lat_0=43.737 +lon_0=7.426 +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs"),
      OGRERR_NONE);
  OGRCoordinateTransformation* transform = OGRCreateCoordinateTransformation(&wgs84, &ortho);
  ASSERT_NE(transform, nullptr);
  for (double d = -0.3; d <= 0.3; d += 0.05) {
    double x = origin.longitude_deg + d, y = origin.latitude_deg + 0.7 * d;
    const glm::dvec3 ours = frame.to_local_m({y, x, 0});
    ASSERT_TRUE(transform->Transform(1, &x, &y));
    EXPECT_NEAR(ours.x, x, 1e-6);
    EXPECT_NEAR(ours.y, y, 1e-6);
  }
  OGRCoordinateTransformation::DestroyCT(transform);
}

TEST(LocalFrame, LengthDistortionBoundsWhatALevelLengthLoses) {
  const LocalFrame frame({45, 10, 0});
  const double north_deg = 45.9, step_deg = 1e-4;
  const glm::dvec3 a = frame.to_local_m({north_deg, 10, 0}), b = frame.to_local_m({north_deg + step_deg, 10, 0});
  const double seen = glm::length(glm::dvec2(b) - glm::dvec2(a)), real = glm::length(b - a);
  EXPECT_GT(1 - seen / real, 0);
  EXPECT_NEAR(1 - seen / real, length_distortion(a.y), 0.02 * length_distortion(a.y));
}

}  // namespace
}  // namespace roadgen
