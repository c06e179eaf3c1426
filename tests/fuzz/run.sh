#!/usr/bin/env bash
# Runs every fuzz target of build/fuzz from its corpus: tests/fuzz/run.sh [SECONDS of each, default 20] [TARGET...]
# What a target finds anew is kept in build/fuzz/found/TARGET; an input that breaks it is told with its path.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-20}; shift || true
[ $# -gt 0 ] || set -- opendrive osm_xml osm_pbf gpx csv geojson scene point_cloud
# Leaks are those of GDAL and the rest at exit.
export ASAN_OPTIONS=detect_leaks=0
for name in "$@"; do
  found=build/fuzz/found/$name
  mkdir -p "$found"
  options=()
  [ ! -f "tests/fuzz/$name.dict" ] || options=("-dict=tests/fuzz/$name.dict")
  log=build/fuzz/$name.log
  echo "fuzz: $name for $seconds s"
  build/fuzz/bin/"${name}_fuzz" -max_total_time="$seconds" -rss_limit_mb=1024 -timeout=10 -max_len=65536 \
    -artifact_prefix="build/fuzz/$name-" "${options[@]}" \
    "$found" "tests/fuzz/corpus/$name" >"$log" 2>&1 || { tail -40 "$log" >&2; echo "fuzz: $name failed" >&2; exit 1; }
  tail -1 "$log"
done
