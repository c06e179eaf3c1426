#!/usr/bin/env bash
# Configures and builds one preset: .ci/build.sh PRESET [TARGET...]
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1; shift
if [ ! -f "build/$preset/build.ninja" ]; then
  echo "build: configuring '$preset'"
  cmake --preset "$preset" >"build-$preset.log" 2>&1 || { cat "build-$preset.log" >&2; rm -f "build-$preset.log"; echo "build: configuring '$preset' failed" >&2; exit 1; }
  rm -f "build-$preset.log"
fi
echo "build: building '$preset'"
cmake --build --preset "$preset" ${1:+--target "$@"}
