// A file that is read where it lies, as if it were in memory. Internal to terrain.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "roadgen/road/result.h"

namespace roadgen {

// Requires of others: the file is not made shorter while it is mapped; to replace it, a new one is renamed onto it, as
// write_terrain_file does.
class MappedFile {
 public:
  // Errors: kIo where it cannot be opened.
  static Result<std::shared_ptr<const MappedFile>> open(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const char> bytes() const { return {static_cast<const char*>(data_), size_}; }
  // Gives back the memory of a part; it is read again when it is asked for.
  void release(std::span<const char> part) const;

 private:
  MappedFile(void* data, std::size_t size) : data_(data), size_(size) {}
  void* data_;
  std::size_t size_;
};

}  // namespace roadgen
