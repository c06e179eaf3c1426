// The readers of point clouds on any bytes; the first says which.
#include <cstddef>
#include <cstdint>

#include <string_view>

#include "roadgen/import/point_cloud.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const char* const file = data[0] == 'x' ? "fuzz.xyzr" : (data[0] == 'p' ? "fuzz.pdb" : "fuzz.ply");
  (void)roadgen::parse_point_cloud(text, file, {.radius = 1});
  return 0;
}
