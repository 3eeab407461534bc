#!/usr/bin/env bash
# Builds with the address and undefined-behaviour sanitizers, in build-asan/, and runs the unit tests and a few steps of every scene.
#
#   bash jobscripts/sanitize.sh [--quick] [--no-install] [--jobs N]
#
#   --quick        three unit tests that need no whole program: minutes instead of half an hour
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers, then cores for tests, at a time; default: one per core, as far as memory goes
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

quick=()
while (($#)); do
    if [[ $1 == --quick ]]; then
        quick=(core_test_x86_64_v3 parallel_test loads_test)
        shift
        continue
    fi
    take_option "$@" || die "unknown argument '$1'; see --help"
    shift "$taken"
done

cd "$root"
say "Packages"
bash jobscripts/install.sh --tests "${no_install[@]}"
say "Building build-asan/ with $jobs jobs"
cmake --preset asan
if ((${#quick[@]})); then
    # One by one: make would build what two of them need twice at once.
    for target in "${quick[@]}"; do cmake --build --preset asan --target "$target" --parallel "$jobs"; done
else
    for target in skein sanitized_tests; do cmake --build --preset asan --target "$target" --parallel "$jobs"; done
fi

# What MPI and HDF5 leave behind at exit is theirs; mismatched frees are Open MPI's.
export ASAN_OPTIONS=detect_leaks=0:alloc_dealloc_mismatch=0
say "Unit tests"
if ((${#quick[@]})); then
    export GTEST_FILTER='-*Jump*' # many small motions of the same few pairs
    exec ctest --preset asan --tests-regex "^($(IFS='|'; echo "${quick[*]}"))\$" --no-tests=error --parallel "$jobs"
fi
ctest --preset asan --label-regex '^sanitized$' --no-tests=error --parallel "$jobs"

say "A few steps of every scene"
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for scene in apps/*/*.toml; do
    [[ $scene != *farm_* ]] || continue # as carpet_8x8, and larger than sanitizers like
    echo "$scene"
    build-asan/bin/skein run "$scene" --quiet --steps 130 --threads 2 --out "$results/$(basename "$scene" .toml)" || (($? == 3)) || die "$scene"
done
