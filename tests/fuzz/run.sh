#!/usr/bin/env bash
# Runs every fuzz target of build/fuzz from its corpus: tests/fuzz/run.sh [SECONDS of each, default 10] [TARGET...]
# What a target finds anew is kept in build/fuzz/found/TARGET; an input that breaks it is told with its path.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-10}; shift || true
[ $# -gt 0 ] || set -- opendrive osm_xml osm_pbf gpx csv geojson scene point_cloud
# Leaks are those of GDAL and the rest at exit.
export ASAN_OPTIONS=detect_leaks=0
run() {
  local name=$1 options=()
  local found=build/fuzz/found/$name log=build/fuzz/$name.log
  mkdir -p "$found"
  [ ! -f "tests/fuzz/$name.dict" ] || options=("-dict=tests/fuzz/$name.dict")
  echo "fuzz: $name for $seconds s"
  build/fuzz/bin/"${name}_fuzz" -max_total_time="$seconds" -rss_limit_mb=1024 -timeout=10 -max_len=65536 \
    -artifact_prefix="build/fuzz/$name-" "${options[@]}" \
    "$found" "tests/fuzz/corpus/$name" >"$log" 2>&1 || { tail -40 "$log" >&2; echo "fuzz: $name failed" >&2; exit 1; }
  echo "fuzz: $name: $(tail -1 "$log")"
}
export -f run
export seconds
printf '%s\n' "$@" | xargs -P "$(nproc)" -I{} bash -c 'set -euo pipefail; run {}'
