// Counts what a test's program allocates.
#pragma once

#include <cstddef>

namespace roadgen::test {

// Calls of operator new so far, in all threads. 0 under AddressSanitizer.
std::size_t allocation_count();

}  // namespace roadgen::test
