#!/usr/bin/env bash
# The main job, from a bare Debian 12: installs what is missing, builds, imports the roads of the given files (or of
# data/), prints their certificates, and flies along them. Results in out/.
#   ./demo/run.sh [FILE...]    FILE: .csv .geojson .gpx roads; a .hgt .hgt.zip .tif .asc file is taken as the elevation
# FRAMES (default 240) and SIZE (default 1280x720) may be set in the environment.
set -euo pipefail
start=$PWD
cd "$(dirname "$0")/.."
.ci/setup.sh
.ci/build.sh release roadgen_cli town

die() { echo "demo: $*" >&2; exit 1; }
roads=() dem=()
for file in "$@"; do
  case "$file" in /*) ;; *) file=$start/$file ;; esac
  [ -e "$file" ] || die "$file: no such file"
  case "${file,,}" in *.hgt|*.hgt.zip|*.tif|*.tiff|*.asc) dem=(--dem "$file") ;; *) roads+=("$file") ;; esac
done

roadgen=build/release/bin/roadgen
mkdir -p out
frames=${FRAMES:-240} size=${SIZE:-1280x720}

# fly NAME [--dem DEM]: the fly-through and its contact sheet, along the longest road of out/NAME.xodr
fly() {
  local name=$1; shift
  echo "== $name: $frames frames along the road"
  "$roadgen" fly "out/$name.xodr" "$@" --frames "$frames" --size "$size" -o "out/$name.mp4" --contact-sheet "out/$name.png"
}
# import NAME FILE...: the network and its certificate
import() {
  local name=$1; shift
  echo "== $name: import of $*"
  "$roadgen" import "$@" -o "out/$name.xodr" --report "out/$name.json"
  "$roadgen" check "out/$name.xodr" --report "out/$name.check.json" >/dev/null
}

if [ ${#roads[@]} -gt 0 ]; then
  name=$(basename "${roads[0]%.*}")
  import "$name" "${roads[@]}"
  fly "$name" "${dem[@]}"
else
  import pass data/pass.csv
  fly pass --dem "${dem[1]:-data/pass_dem.tif}"
  import circuit data/circuit.csv --closed yes
  "$roadgen" render out/circuit.xodr --follow 1,400,0,1.5 --size "$size" -o out/circuit >/dev/null
  echo "== town: junction, kerbs, markings, structures"
  build/release/bin/town out/town
fi
echo "== done; in out/:"
ls -1 out
