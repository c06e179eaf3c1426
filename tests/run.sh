#!/usr/bin/env bash
# Sets up, builds and runs every test. Arguments go to ctest: ./tests/run.sh -L unit
set -euo pipefail
cd "$(dirname "$0")/.."
.ci/setup.sh
.ci/build.sh release
echo "tests: release build"
ctest --preset release -j"$(nproc)" "$@"
.ci/build.sh asan tests_unit tests_cli
echo "tests: under AddressSanitizer and UBSan"
# Leaks are those of Mesa, GDAL and the rest at exit. Left out: what takes a minute here, and runs code that others run too.
ASAN_OPTIONS=detect_leaks=0 ctest --preset asan -j"$(nproc)" -L 'unit|cli' \
  -E 'HundredThousand|OnRealRoads|BoundJunctions|ThroughTheFileIsTheSamePicture' "$@"
.ci/build.sh fuzz
tests/fuzz/run.sh
