// The reader of scenes on any bytes. What files they name are sought in a folder that is not there.
#include <cstddef>
#include <cstdint>

#include <string_view>

#include "roadgen/import/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)roadgen::parse_scene(text, "nowhere/fuzz.json");
  return 0;
}
