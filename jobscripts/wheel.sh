#!/usr/bin/env bash
# Builds a wheel of the Python package, with the program and its library in it, for machines with the same system packages.
#
#   bash jobscripts/wheel.sh [--no-install] [--jobs N] [DIRECTORY]
#
#   DIRECTORY      where it goes; default: out/wheels
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers at a time; default: one per core, as far as memory goes
#
# Environment: PYTHON, the interpreter with setuptools, wheel and pip; default /usr/bin/python3.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

to=$root/out/wheels
while (($#)); do
    if take_option "$@"; then
        shift "$taken"
        continue
    fi
    case $1 in
    -*) die "unknown argument '$1'; see --help" ;;
    *) to=$(realpath -m "$1") ;;
    esac
    shift
done

cd "$root"
say "Packages"
bash jobscripts/install.sh "${no_install[@]}"
options=()
[[ -f build/CMakeCache.txt ]] || options=(-DSKEIN_TESTS=OFF -DSKEIN_BENCH=OFF)
build skein "$jobs" "${options[@]}" "-DSKEIN_WIDTHS=1;2;4;8"
build skein_shared "$jobs"
say "Wheel"
"${PYTHON:-/usr/bin/python3}" -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir "$to" python
ls "$to"/*.whl
