#!/usr/bin/env bash
# Builds everything and runs the tests.
#
#   bash jobscripts/test.sh [--no-install] [--jobs N] [-L LABEL]...
#
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers, then cores for tests, at a time; default: one per core, as far as memory goes
#   -L LABEL       only these tests: fast, unit, mpi, fault, validation, stress, architecture (may be repeated)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

labels=()
while (($#)); do
    if take_option "$@"; then
        shift "$taken"
        continue
    fi
    case $1 in
    -L) [[ -n ${2-} ]] || die "-L needs a label"; labels+=("$2"); shift ;;
    *) die "unknown argument '$1'; see --help" ;;
    esac
    shift
done

cd "$root"
say "Packages"
bash jobscripts/install.sh --tests "${no_install[@]}"
build all "$jobs" -DSKEIN_TESTS=ON -DSKEIN_BENCH=ON -DSKEIN_FLUID=ON -DSKEIN_PETSC=ON "-DSKEIN_WIDTHS=1;2;4;8"

# Every test says how many cores it may use (PROCESSORS). Tests of whole runs wait for discs and launchers a third of their time:
# ctest packs them into half as many cores again. With more, ranks that wait for each other's messages share a core with others.
only=()
if ((${#labels[@]})); then
    only=(--label-regex "^($(IFS='|'; echo "${labels[*]}"))\$")
fi
say "Testing"
exec ctest --test-dir build --output-on-failure --no-tests=error --parallel $((jobs + (jobs + 1) / 2)) "${only[@]}"
