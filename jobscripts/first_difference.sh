#!/usr/bin/env bash
# Finds the first step after which two programs, or one program with two sets of options, have different states.
#
#   bash jobscripts/first_difference.sh SCENE STEPS "PROGRAM [OPTION]..." "PROGRAM [OPTION]..."
#
# Example: the same scene on one lane and on eight.
#   bash jobscripts/first_difference.sh apps/active_matter/pit_96.toml 4000 "build/bin/skein --lanes 1" "build/bin/skein --lanes 8"
#
# States that differ once are taken to differ from then on, so the step is bisected: each comparison is two runs from the start.
set -euo pipefail
(($# == 4)) || { sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 2; }
scene=$1 steps=$2
read -ra one <<<"$3"
read -ra other <<<"$4"
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

digest() { # digest of the state after $1 steps of the program $2 with options
    local n=$1
    shift
    rm -rf "$results/run"
    "$1" run "$scene" "${@:2}" --quiet --no-checkpoint --steps "$n" --out "$results/run" >/dev/null || (($? == 3)) || exit 1
    sed -n 's/.*"digest": "\(.*\)".*/\1/p' "$results/run/summary.json"
}
differ() {
    local a b
    a=$(digest "$1" "${one[@]}") || exit 1
    b=$(digest "$1" "${other[@]}") || exit 1
    [[ $a != "$b" ]]
}

differ "$steps" || { echo "equal after $steps steps"; exit 0; }
same=0 different=$steps
while ((different - same > 1)); do
    middle=$(((same + different) / 2))
    if differ "$middle"; then different=$middle; else same=$middle; fi
done
echo "equal after $same steps, different after $different"
