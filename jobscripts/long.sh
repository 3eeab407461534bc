#!/usr/bin/env bash
# The longer set of tests, for a change that is complete: long runs of stress tests, all trials of faults, and shipped scenes at full length.
#
#   bash jobscripts/long.sh [--no-install] [--jobs N] [--minutes M]
#
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers, then cores for tests, at a time; default: one per core, as far as memory goes
#   --minutes M    leave out scenes whose steps are predicted to take longer; default 2
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

minutes=2
while (($#)); do
    if take_option "$@"; then
        shift "$taken"
        continue
    fi
    case $1 in
    --minutes) [[ ${2-} =~ ^[0-9.]+$ ]] || die "--minutes needs a number"; minutes=$2; shift ;;
    *) die "unknown argument '$1'; see --help" ;;
    esac
    shift
done

cd "$root"
say "Packages"
bash jobscripts/install.sh --tests "${no_install[@]}"
build all "$jobs" -DSKEIN_TESTS=ON -DSKEIN_FLUID=ON "-DSKEIN_WIDTHS=1;2;4;8"

say "Tests at their full length"
SKEIN_LONG=1 ctest --test-dir build -L '^(stress|fault|validation)$' --output-on-failure --no-tests=error --parallel "$jobs"
say "Scenes at their full length"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
exec /usr/bin/python3 tests/long/full_length.py "$root/build/bin/skein" mpirun --minutes "$minutes"
