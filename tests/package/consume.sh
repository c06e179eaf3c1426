#!/usr/bin/env bash
# consume.sh BUILD SOURCE: installs BUILD into a fresh prefix, builds demo/embed_c against it twice, by
# find_package and by pkg-config, in plain C, and runs both on an imported road.
set -euo pipefail
build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >/dev/null
# By the installed program, which finds the fit's library there.
"$work/prefix/bin/roadgen" import "$source/data/pass.csv" -o "$work/pass.xodr" >/dev/null 2>&1

cmake -G Ninja -S "$source/demo/embed_c" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$work/prefix" \
      ${CMAKE_C_FLAGS:+-DCMAKE_C_FLAGS="$CMAKE_C_FLAGS"} >/dev/null
cmake --build "$work/consumer" >/dev/null
"$work/consumer/embed_c" "$work/pass.xodr" "$work/picture.ppm"
[ "$(head -c 2 "$work/picture.ppm")" = P6 ] || { echo "no picture"; exit 1; }

pc=$(dirname "$(find "$work/prefix" -name roadgen.pc)")
cc -std=c11 -Wall -Wextra -Werror "$source/demo/embed_c/main.c" -o "$work/by_pkg_config" \
   $(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs roadgen) -lm
LD_LIBRARY_PATH=$(dirname "$pc") "$work/by_pkg_config" "$work/pass.xodr" "$work/picture2.ppm"
cmp "$work/picture.ppm" "$work/picture2.ppm"

# A missing file is an error with the file's name, not a crash.
if "$work/consumer/embed_c" "$work/none.xodr" "$work/none.ppm" 2>"$work/message"; then echo "missing file accepted"; exit 1; fi
grep -q none.xodr "$work/message"
