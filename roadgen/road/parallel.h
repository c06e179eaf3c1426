// Work over ranges on all cores, with results that do not depend on how many there are. oneTBB would do the same, and take
// a megabyte more of an import that takes 14.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace roadgen {

// Calls work(chunk, begin, end) for consecutive chunks of [0, count), each of `size` but the last, from several threads
// at once. Requires: work does not throw.
template <class Work>
void for_chunks(std::size_t count, std::size_t size, const Work& work) {
  const std::size_t chunks = (count + size - 1) / size;
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t chunk = next++; chunk < chunks; chunk = next++) {
      work(chunk, chunk * size, std::min(count, (chunk + 1) * size));
    }
  };
  std::vector<std::thread> threads;
  const std::size_t most = std::max(1u, std::thread::hardware_concurrency());
  for (std::size_t i = 1; i < std::min(most, chunks); ++i) threads.emplace_back(run);
  run();
  for (std::thread& thread : threads) thread.join();
}

// Calls work(i) for every i in [0, count), likewise.
template <class Work>
void for_each_index(std::size_t count, const Work& work) {
  for_chunks(count, 64, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
}

}  // namespace roadgen
