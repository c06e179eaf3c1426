#!/usr/bin/env bash
# Installs the packages of .ci/packages.txt that are missing. Needs root or sudo only when something is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

die() { echo "setup: $*" >&2; exit 1; }

[ -r /etc/debian_version ] || die "this script installs Debian packages; on another system install the equivalents of .ci/packages.txt"
mapfile -t packages < <(sed 's/#.*//' .ci/packages.txt | awk 'NF {print $1}')

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [ "$status" = "install ok installed" ] || missing+=("$package")
done
if [ ${#missing[@]} = 0 ]; then
  echo "setup: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || die "not root and no sudo; as root run: apt-get install ${missing[*]}"
  as_root=(sudo)
fi
echo "setup: installing ${#missing[@]} of ${#packages[@]} packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
"${as_root[@]}" apt-get update -qq >"$log" 2>&1 || echo "setup: apt-get update failed ($(tail -1 "$log")); going on with the package lists at hand" >&2
for package in "${missing[@]}"; do
  apt-cache show "$package" >/dev/null 2>&1 || die "package '$package' is not in the apt sources; add a Debian 12 source to /etc/apt/sources.list"
done
DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y --no-install-recommends -o Dpkg::Use-Pty=0 "${missing[@]}" >"$log" 2>&1 \
  || die "apt-get install failed: $(grep -m1 '^E:' "$log" || tail -1 "$log")"
echo "setup: done"
