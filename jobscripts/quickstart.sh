#!/usr/bin/env bash
# From a fresh Debian 12 machine to a picture: installs what is missing, builds, runs a carpet of 64 magnetic cilia, draws it.
#
#   bash jobscripts/quickstart.sh [--no-install] [--build-only] [--jobs N]
#
#   --no-install   install no packages; say which are missing
#   --build-only   stop after the build
#   --jobs N       compilers at a time; default: one per core, as far as memory goes
#
# The same command again goes on where the run was stopped, or draws the finished run anew.
# Environment: PYTHON, the interpreter with numpy, h5py and matplotlib; default /usr/bin/python3.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

build_only=no
while (($#)); do
    if take_option "$@"; then
        shift "$taken"
        continue
    fi
    case $1 in
    --build-only) build_only=yes ;;
    *) die "unknown argument '$1'; see --help" ;;
    esac
    shift
done

cd "$root"
say "Packages"
bash jobscripts/install.sh "${no_install[@]}"

# The first build has the fluid, and the kernels of this processor. It leaves out tests, benchmarks, multigrid and the kernels of other
# processors; a build/ that has them keeps them. The rest: cmake -B build -DSKEIN_WIDTHS="1;2;4;8"
options=()
[[ -f build/CMakeCache.txt ]] || options=(-DSKEIN_TESTS=OFF -DSKEIN_BENCH=OFF -DSKEIN_PETSC=OFF -DSKEIN_WIDTHS=native)
build skein "$jobs" "${options[@]}"
say "Checking the build"
build/bin/skein check --self
if [[ $build_only == yes ]]; then
    say "Built: build/bin/skein"
    exit
fi

scene=apps/cilia_carpet/carpet_8x8.toml
out=out/carpet_8x8

launch=(mpirun -n 2)
threads=()
((EUID != 0)) || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 # Open MPI asks root to say so
# Open MPI counts cores, not their hardware threads, and wants one for each rank.
cores=$(lscpu --parse=CORE,SOCKET | grep -v '^#' | sort -u | wc -l)
if ((cores < 2 || $(nproc) < 2)); then
    launch+=(--oversubscribe)
    threads=(--threads 1)
fi
run=("${launch[@]}" build/bin/skein run "$scene" "${threads[@]}")

say "Running: ${run[*]}"
"${run[@]}" || die "the run ended with code $?; a run stopped half-way goes on when started again, and with --overwrite begins anew"

say "Drawing"
"${PYTHON:-/usr/bin/python3}" apps/cilia_carpet/plot.py "$out"

say "Done"
for picture in "$out"/*.png; do echo "  $root/$picture"; done
echo "Also there: *.xdmf for ParaView, observables.csv, summary.json. Next: README.md"
