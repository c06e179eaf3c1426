// The reader of OpenStreetMap's PBF on any bytes.
#include <cstddef>
#include <cstdint>

#include "roadgen/import/osm_file.h"
#include "tests/fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const roadgen::test::InputFile file("fuzz.pbf");
  roadgen::ElementFindings findings(file.path());
  (void)roadgen::read_osm(file.put(data, size), findings);
  return 0;
}
