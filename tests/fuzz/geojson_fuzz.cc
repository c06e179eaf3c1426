// The reader of vector files, on any bytes that are called GeoJSON.
#include <cstddef>
#include <cstdint>

#include "roadgen/import/ogr.h"
#include "tests/fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const roadgen::test::InputFile file("fuzz.geojson");
  roadgen::Diagnostics diagnostics;
  (void)roadgen::read_vector(file.put(data, size), {}, diagnostics);
  return 0;
}
