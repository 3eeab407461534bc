#!/usr/bin/env bash
# Everything in the table of docs/faults.md with all trials: about an hour.
#
#   bash jobscripts/faults.sh [--no-install] [--jobs N]
#
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers, then cores for tests, at a time; default: one per core, as far as memory goes
#
# The Slurm jobs run where a cluster of one node can be made (root, slurm-wlm, munge). Sanitizers have a script of their own, sanitize.sh.
# Environment: SKEIN_SEED, another seed for trials that are drawn (1).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

while (($#)); do
    take_option "$@" || die "unknown argument '$1'; see --help"
    shift "$taken"
done

cd "$root"
say "Packages"
bash jobscripts/install.sh --tests "${no_install[@]}"
build all "$jobs" -DSKEIN_TESTS=ON "-DSKEIN_WIDTHS=1;2;4;8"

# Trials first; then the rows that other tests have.
export SKEIN_LONG=1
failed=()
say "Trials"
ctest --test-dir build -L '^fault$' --verbose --no-tests=error --parallel "$jobs" || failed+=("trials")
unset SKEIN_LONG
say "Other rows"
ctest --test-dir build --output-on-failure --no-tests=error --parallel "$jobs" \
    -R '^(driver\.|jobscripts\.|(exception|no_memory)_on_one_rank$|same_files_test$|io_mpi_test|scene_test$|stress\.stopped$)' || failed+=("other rows")
say "Jobs of Slurm"
bash tests/jobscripts/slurm_test.sh || (($? == 77)) || failed+=("jobs of Slurm")

((${#failed[@]} == 0)) || die "failed: $(IFS=,; echo "${failed[*]}")"
say "All rows passed"
