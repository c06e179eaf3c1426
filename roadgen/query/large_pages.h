// Memory for arrays that are read at random. A part of RoadIndex (road_index.h).
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace roadgen {

// Arrays of some megabytes lie in the system's large pages, where it has them (Linux, transparent_hugepage not "never"):
// reading at random then rarely waits for page tables.
template <class T>
struct LargePages {
  using value_type = T;
  static constexpr std::size_t kPage = std::size_t{1} << 21;

  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* memory = ::operator new(bytes, alignment(bytes));
#if defined(__linux__)
    if (bytes >= 2 * kPage) ::madvise(memory, bytes, MADV_HUGEPAGE);  // where it cannot be, nothing is lost
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) { ::operator delete(memory, alignment(count * sizeof(T))); }

  template <class U>
  bool operator==(const LargePages<U>&) const {
    return true;
  }

 private:
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{bytes >= 2 * kPage ? kPage : alignof(T)};
  }
};

template <class T>
using LargeVector = std::vector<T, LargePages<T>>;

}  // namespace roadgen
