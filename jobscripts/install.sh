#!/usr/bin/env bash
# Installs the Debian 12 packages that Skein needs and this machine lacks.
#
#   bash jobscripts/install.sh [--pictures] [--tests] [--no-install]
#
#   --pictures     also what `skein draw` has shadows, movies and pages from: VTK, a display for it, ffmpeg, three.js
#   --tests        also what only tests and benchmarks need
#   --no-install   only say what is missing; otherwise it is installed, as root or through sudo
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

packages=(
    g++ cmake make pkg-config                                              # compiler and build
    openmpi-bin libopenmpi-dev libtbb-dev libhdf5-openmpi-dev zlib1g-dev   # ranks, threads, files
    libcli11-dev libtomlplusplus-dev tao-pegtl-dev libfmt-dev nlohmann-json3-dev # command line, scenes, formulas, text
    libeigen3-dev libspectra-dev                                           # equilibria
    libfftw3-dev                                                           # fluid
    python3 python3-numpy python3-h5py python3-matplotlib                  # figures
)
picture_packages=(python3-vtk9 xvfb ffmpeg libjs-three)
test_packages=(petsc-dev libopenblas0-serial xvfb libjs-three chromium libgtest-dev libbenchmark-dev clang-format-14 qemu-user binutils python3-paraview) # ParaView: a test opens results with its readers

install=yes
tests=no
pictures=no
for argument in "$@"; do
    case $argument in
    --no-install) install=no ;;
    --tests) tests=yes ;;
    --pictures) pictures=yes ;;
    -h | --help) help; exit ;;
    *) die "unknown argument '$argument'; see --help" ;;
    esac
done

[[ $pictures == no ]] || packages+=("${picture_packages[@]}")
[[ $tests == no ]] || packages+=("${test_packages[@]}")

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    [[ $install == no ]] && { echo "Not a Debian machine: packages are not checked."; exit; }
    die "this is not Debian. Provide by other means what these packages hold, then use --no-install: ${packages[*]}"
fi

installed() { [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

missing=()
for package in "${packages[@]}"; do
    if installed "$package"; then continue; fi
    if [[ $package == python3-paraview ]] && installed python3-vtk9; then
        echo "Not taken: $package, which excludes the python3-vtk9 that is here; the tests that open XDMF files with ParaView's readers are left out."
        continue
    fi
    if [[ $package == python3-vtk9 ]] && { [[ $tests == yes ]] || installed python3-paraview; }; then continue; fi # ParaView brings a VTK of its own
    missing+=("$package")
done
if ((${#missing[@]} == 0)); then
    echo "All ${#packages[@]} packages are installed."
    exit
fi
if [[ $install == no ]]; then
    echo "Missing, and not installed because of --no-install: ${missing[*]}"
    exit
fi

as_root=(env DEBIAN_FRONTEND=noninteractive)
if ((EUID != 0)); then
    command -v sudo >/dev/null || die "missing: ${missing[*]}. Neither root nor sudo: ask for 'apt-get install ${missing[*]}', then use --no-install"
    as_root=(sudo "${as_root[@]}")
fi

# Another apt may hold the lock, a mirror may stumble: four tries.
apt() {
    local pause
    for pause in 5 20 60 0; do
        "${as_root[@]}" apt-get -qq -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" </dev/null && return
        ((pause == 0)) || { echo "apt-get $1 failed; once more in $pause s" >&2; sleep "$pause"; }
    done
    die "apt-get $* failed; see above"
}

say "Installing ${#missing[@]} package$( ((${#missing[@]} == 1)) || echo s): ${missing[*]}"
apt update
apt install -y --no-remove --no-install-recommends "${missing[@]}" >/dev/null
echo "Installed."
