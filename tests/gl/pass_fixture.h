// The pass of data/: its road, imported, and its elevation.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "roadgen/import/import.h"
#include "terrain/elevation.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen::test {

class PassTest : public GlTest {
 protected:
  void SetUp() override {
    const std::string data = std::string(ROADGEN_SOURCE_DIR) + "/data/";
    auto imported = import_files({data + "pass.csv"}, {});
    ASSERT_TRUE(imported.ok()) << imported.error().text();
    network_ = std::move(imported->network);
    auto elevation = Elevation::open(data + "pass_dem.tif");
    ASSERT_TRUE(elevation.ok()) << elevation.error().text();
    elevation_.emplace(std::move(*elevation));
  }

  Network network_;
  std::optional<Elevation> elevation_;
};

}  // namespace roadgen::test
