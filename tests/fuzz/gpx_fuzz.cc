// The reader of GPX on any bytes.
#include <cstddef>
#include <cstdint>

#include <string_view>

#include "roadgen/import/gpx.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  roadgen::Diagnostics diagnostics;
  const roadgen::FieldNames fields{.width = "width", .lanes = "lanes", .height = "height", .name = "desc"};
  (void)roadgen::parse_gpx(text, "fuzz.gpx", {}, diagnostics);
  (void)roadgen::parse_gpx(text, "fuzz.gpx", fields, diagnostics);
  return 0;
}
