// The reader of tables on any bytes.
#include <cstddef>
#include <cstdint>

#include <string_view>

#include "roadgen/import/csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  roadgen::Diagnostics diagnostics;
  (void)roadgen::parse_csv(text, "fuzz.csv", {}, diagnostics);
  return 0;
}
