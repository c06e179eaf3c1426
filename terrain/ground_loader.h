// Reads the ground's tiles beside the drawing: what a view wishes for, in the order of its wishes, within a bound of memory.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "terrain/ground_source.h"

namespace roadgen {

class GroundLoader {
 public:
  // Starts a thread, where the source is not in memory.
  explicit GroundLoader(std::shared_ptr<const GroundSource> source);
  ~GroundLoader();
  GroundLoader(const GroundLoader&) = delete;
  GroundLoader& operator=(const GroundLoader&) = delete;

  const GroundSource& source() const { return *source_; }
  // How many bands of a tile may be read without waiting.
  std::uint32_t loaded(std::size_t tile) const;
  std::size_t loaded_bytes() const;  // of all tiles, and on their way; 0 of a source in memory
  // Loads them here and now. Errors: the source's.
  Status load(std::size_t tile, std::uint32_t bands);
  void release(std::size_t tile);

  struct Wish {
    std::size_t tile;
    std::uint32_t bands;
  };
  // What is to be read from now on, the first first, in place of earlier wishes; as much of it as goes into the bytes. Other
  // tiles are released as far as that needs room. Errors: the source's, of earlier wishes.
  Status wish(const std::vector<Wish>& wishes, std::size_t most_bytes);

 private:
  void run();
  // The next that is not there yet.
  std::optional<Wish> next() const;
  void set_loaded(std::size_t tile, std::uint32_t bands);

  std::shared_ptr<const GroundSource> source_;
  std::vector<std::atomic<std::uint32_t>> loaded_;  // written under the mutex
  mutable std::mutex mutex_;                        // of all below
  std::condition_variable wished_;
  std::size_t bytes_ = 0, reading_bytes_ = 0, most_bytes_ = 0;  // loaded; by the thread now; that it may come to
  std::vector<Wish> wishes_;
  Status failed_ = Done{};
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace roadgen
