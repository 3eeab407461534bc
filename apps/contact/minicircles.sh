#!/usr/bin/env bash
# Minicircles of several excess links, one after another, and their picture: minicircles.sh [TURNS], by default those of README.md.
# Results: out/minicircle_<turns>; runs that are there are left as they are. SKEIN: the program, OUT: where to write instead of out.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
skein=${SKEIN:-$root/build/bin/skein}
out=${OUT:-out}
results=()
for turns in ${1:-1.1 1.2 1.4 1.7 2 2.5 3 4}; do
    to="$out/minicircle_$turns"
    "$skein" run "$root/apps/contact/minicircle.toml" --out "$to" -q \
        --set "rods.ring.shape.rest_curvature=[0.0, 0.0, $(awk "BEGIN { printf \"%.17g\", -8 * atan2(1, 1) * $turns }")]"
    results+=("$to")
done
/usr/bin/python3 "$root/apps/contact/plot_minicircle.py" "${results[@]}" --to "$out/minicircles.png"
