# Sourced by the job scripts: the checkout, messages, and how build/ is configured and built.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '\n== %s\n' "$*"; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# The comment at the head of the calling script, as its --help.
help() { sed -n '2,/^[^#]/ { s/^# \{0,1\}//; t show; d; :show; p }' "$0"; }

# One compiler per core this process may use, and 1.5 GB of memory for each.
default_jobs() {
    local cores memory
    cores=$(nproc)
    memory=$(awk '/^MemAvailable:/ { print int($2 / 1500000) }' /proc/meminfo)
    echo $((memory < 1 ? 1 : memory < cores ? memory : cores))
}

# Options that all scripts which build share: takes the first of "$@", and with it the next word if it is its value. False where
# the script must know better; else `taken` is how many words went.
no_install=()
jobs=$(default_jobs)
take_option() {
    taken=1
    case $1 in
    --no-install) no_install=(--no-install) ;;
    --jobs) jobs=${2-} taken=$(($# < 2 ? 1 : 2)) ;;
    --jobs=*) jobs=${1#*=} ;;
    -h | --help) help; exit ;;
    *) return 1 ;;
    esac
    [[ $jobs =~ ^[1-9][0-9]*$ ]] || die "--jobs needs a positive number"
}

# build <target> <jobs> [cmake options]: Release, in build/. A build/ that is there already keeps its other options; a new one joins
# sources for the compiler, as most users build once.
build() {
    local target=$1 jobs=$2
    shift 2
    command -v cmake >/dev/null || die "cmake is missing; run without --no-install, or see jobscripts/install.sh --no-install"
    [[ $root != *[[:space:]]* ]] || die "'$root' has a space in it, and HDF5 is not found from there; move the checkout"
    [[ -f $root/build/CMakeCache.txt ]] || set -- -DSKEIN_UNITY=ON "$@"
    say "Configuring build/"
    cmake -S "$root" -B "$root/build" -DCMAKE_BUILD_TYPE=Release "$@"
    say "Building $target with $jobs job$([[ $jobs == 1 ]] || echo s)"
    cmake --build "$root/build" --target "$target" --parallel "$jobs"
}
