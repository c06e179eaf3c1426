#!/usr/bin/env bash
# Sets up, builds and runs every test. Arguments go to ctest: ./tests/run.sh -L unit
set -euo pipefail
cd "$(dirname "$0")/.."
.ci/setup.sh
.ci/build.sh release
echo "tests: release build"
ctest --preset release "$@"
.ci/build.sh asan
echo "tests: under AddressSanitizer and UBSan"
# Mesa's own allocations at exit are not ours to fix; everything else is checked.
ASAN_OPTIONS=detect_leaks=0 ctest --preset asan -L 'unit|cli' "$@"
