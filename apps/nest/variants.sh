#!/usr/bin/env bash
# Seeds and variants of a nest, one after another: variants.sh [SCENE] [SEEDS], by default nest_110.toml and "1 2 3 4 5".
# Results: out/<scene>_<variant>[_seed<n>]; runs that are there go on from their last checkpoint, or are left as they are.
#   hard          the scene as it is: contacts a hundred times as stiff as published
#   soft          as published, k = 1e6 g mm^-1/2 s^-2 and its dashpot
#   frictionless, soft_frictionless   without friction, at rods and walls
#   slow          half the speed of the lid
#   real          rotary inertia as it is, with the published step of 0.88 us; seeds 1 to 3
# SKEIN: the program, SKEIN_FLAGS: more of its flags, OUT: where to write instead of out.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scene=${1:-$root/apps/nest/nest_110.toml}
seeds=${2:-1 2 3 4 5}
skein=${SKEIN:-$root/build/bin/skein}
out=${OUT:-out}
name=$(basename "$scene" .toml)
walls=$(sed -n '/^\[\[wall\]\]/,/^name/s/^name = "\(.*\)"/\1/p' "$scene")
speed=$(sed -n '/^\[wall.servo\]/,/^speed/s/^speed = \([^ ]*\).*/\1/p' "$scene")

soft=(--set contact.stiffness=3.1623e4 --set contact.damping=31.623 --set contact.tangential_damping=0.2)
smooth=(--set contact.friction_from=1e3) # s: never
for wall in $walls; do
    soft+=(--set "wall.$wall.stiffness=3.1623e4" --set "wall.$wall.damping=31.623" --set "wall.$wall.tangential_damping=0.2")
    smooth+=(--set "wall.$wall.friction_from=1e3")
done
slow=(--set "wall.lid.servo.speed=$(awk "BEGIN { print $speed / 2 }")" --set "time.duration=$(awk '/^duration/ { print 2 * $3; exit }' "$scene")")

run() { # variant, seed, settings
    local to="$out/${name}_$1"
    [ "$2" = 1 ] || to+="_seed$2"
    # shellcheck disable=SC2086
    "$skein" run "$scene" --out "$to" --set "rods.sticks.placement.seed=$2" --set output.audit=true ${SKEIN_FLAGS:-} "${@:3}"
}

for seed in $seeds; do
    run hard "$seed"
    run soft "$seed" "${soft[@]}"
    run frictionless "$seed" "${smooth[@]}"
    run soft_frictionless "$seed" "${soft[@]}" "${smooth[@]}"
    run slow "$seed" "${slow[@]}"
    [ "$seed" -gt 3 ] || run real "$seed" --set rods.sticks.material.rotary_inertia_scale=1 --set time.dt=8.8e-7
done
