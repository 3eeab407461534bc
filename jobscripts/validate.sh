#!/usr/bin/env bash
# Runs the validation cases and draws error against elements or step, one figure per case.
#
#   bash jobscripts/validate.sh [--no-install] [--jobs N] [--out FOLDER]
#
#   --no-install   install no packages; say which are missing
#   --jobs N       compilers, then cores for tests, at a time; default: one per core, as far as memory goes
#   --out FOLDER   where tables (CSV) and figures (PNG) go; default: out/validation
#
# Environment: PYTHON, the interpreter with numpy and matplotlib; default /usr/bin/python3.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

out=$root/out/validation
while (($#)); do
    if take_option "$@"; then
        shift "$taken"
        continue
    fi
    case $1 in
    --out) [[ -n ${2-} ]] || die "--out needs a folder"; out=$(realpath -m "$2"); shift ;;
    *) die "unknown argument '$1'; see --help" ;;
    esac
    shift
done

cd "$root"
say "Packages"
bash jobscripts/install.sh --tests "${no_install[@]}"
build validation "$jobs" -DSKEIN_TESTS=ON "-DSKEIN_WIDTHS=1;2;4;8"

say "Running"
failed=0
SKEIN_VALIDATION_OUT=$out ctest --test-dir build -L validation --output-on-failure --no-tests=error --parallel "$jobs" || failed=$?

# Figures are drawn of failed cases too: that is when they are looked at.
say "Drawing"
"${PYTHON:-/usr/bin/python3}" bench/plots/validation.py "$out"
exit "$failed"
