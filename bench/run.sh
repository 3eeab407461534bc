#!/bin/bash
# Runs all benchmarks and keeps their tables in bench/results/<processor>/.
#   bash bench/run.sh [build folder, default build] [folder for results]
# Takes about an hour on one idle machine; needs 4 GB of memory, mpirun, and PYTHON (default /usr/bin/python3) with numpy and
# matplotlib for the figures. Environment: LAYOUTS, ranks x threads of the scaling study ("1x1 1x2 2x1").
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=${1:-$here/../build}
cpu=$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1)
folder=$(printf '%s' "${cpu:-unknown}" | sed -E 's/\((R|TM)\)//g' | tr '[:upper:]' '[:lower:]' | sed -E 's/[^a-z0-9]+/-/g; s/^-|-$//g')
results=${2:-$here/results/$folder}
mkdir -p "$results"

{
  echo "cpu: $cpu"
  lscpu | grep -E '^(CPU\(s\)|L[123]|L1d)' | sed -E 's/ +/ /g'
  echo "commit: $(git -C "$here" describe --always --dirty)"
  echo "date: $(date -u +%F)"
  echo "load: $(cut -d ' ' -f 1-3 /proc/loadavg)"
} > "$results/machine.txt"

python=${PYTHON:-/usr/bin/python3}
read -r -a layouts <<< "${LAYOUTS:-1x1 1x2 2x1}"

"$python" "$here/scaling/scaling.py" --skein "$build/bin/skein" --layouts "${layouts[@]}" --csv "$results/scaling.csv" | tee "$results/scaling.txt"
"$python" "$here/plots/scaling.py" "$results/scaling.csv"
mpirun -n 2 "$build/bin/netcal" --out "$results/machine.toml" | tee "$results/netcal.txt"
"$build/bin/bench_farm" --csv "$results/farm.csv" | tee "$results/farm.txt"
"$python" "$here/plots/ablation.py" "$results/farm.csv"
"$build/bin/bench_passes" --csv "$results/passes.csv" | tee "$results/passes.txt"
"$python" "$here/plots/roofline.py" "$results/passes.csv"
"$build/bin/bench_features" --csv "$results/features.csv" | tee "$results/features.txt"
"$build/bin/bench_mappings" --csv "$results/mappings.csv" | tee "$results/mappings.txt"
"$build/bin/bench_contact" --benchmark_out="$results/contact.csv" --benchmark_out_format=csv
"$build/bin/bench_walls" --benchmark_out="$results/walls.csv" --benchmark_out_format=csv
"$python" "$here/scenes/nest/nest.py" --skein "$build/bin/skein" --csv "$results/nest.csv" | tee "$results/nest.txt"
"$python" "$here/scenes/output/output.py" --skein "$build/bin/skein" --csv "$results/output.csv" | tee "$results/output.txt"
"$build/bin/bench_work_precision" --csv "$results/work_precision.csv" | tee "$results/work_precision.txt"
"$python" "$here/plots/work_precision.py" "$results/work_precision.csv"
"$build/bin/bench_step" --benchmark_out="$results/step.csv" --benchmark_out_format=csv | tee "$results/step.txt"
if [[ -x $build/bin/bench_fluid ]]; then # a build with a fluid
  "$python" "$here/scenes/fluid_work_precision/run.py" --skein "$build/bin/skein" --csv "$results/fluid_work_precision.csv"
  "$python" "$here/plots/fluid_work_precision.py" "$results/fluid_work_precision.csv"
  "$python" "$here/scaling/fluid.py" --skein "$build/bin/skein" --layouts "${layouts[@]}" --csv "$results/fluid_scaling.csv"
fi
