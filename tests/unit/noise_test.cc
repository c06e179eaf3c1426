// The noise averaged over a box against the mean of many of its values.
#include <cmath>

#include <gtest/gtest.h>

#include "shaders/lib/glsl.h"

namespace roadgen {
namespace {

using Lib = glsl::Library<double>;

TEST(Noise, BoxIsTheMeanOfValues) {
  constexpr int kSteps = 200;
  for (const double wide : {0.04, 0.6, 1.0, 5.3}) {
    for (const double high : {0.05, 0.7, 2.9}) {
      for (int place = 0; place < 12; ++place) {
        const double x = -3.1 + 0.83 * place, y = 1.7 - 0.61 * place, wavelength = 0.5;
        double sum = 0;
        for (int i = 0; i < kSteps; ++i) {
          for (int j = 0; j < kSteps; ++j) {
            sum += Lib::noise_value(x + ((i + 0.5) / kSteps - 0.5) * wide, y + ((j + 0.5) / kSteps - 0.5) * high,
                                    wavelength);
          }
        }
        EXPECT_NEAR(Lib::noise_value_box(x, y, wavelength, wide, high), sum / (kSteps * kSteps), 2e-4)
            << x << ", " << y << ": " << wide << " by " << high;
      }
    }
  }
}

TEST(Noise, NarrowBoxIsTheValue) {
  for (double x = -2; x < 2; x += 0.13) {
    EXPECT_NEAR(Lib::noise_value_box(x, 0.4 - x, 0.25, 0.0, 0.0), Lib::noise_value(x, 0.4 - x, 0.25), 1e-3);
  }
}

}  // namespace
}  // namespace roadgen
