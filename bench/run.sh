#!/bin/bash
# Runs all benchmarks and keeps their tables in bench/results/<processor>/.
#   bash bench/run.sh [build folder, default build] [folder for results]
# Takes about seventeen minutes on one idle machine; needs 3 GB of memory, and PYTHON (default /usr/bin/python3) with numpy and
# matplotlib for the figures of error against work.
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

"$build/bin/bench_farm" --csv "$results/farm.csv" | tee "$results/farm.txt"
"$build/bin/bench_work_precision" --csv "$results/work_precision.csv" | tee "$results/work_precision.txt"
"${PYTHON:-/usr/bin/python3}" "$here/plots/work_precision.py" "$results/work_precision.csv"
"$build/bin/bench_passes" --benchmark_out="$results/passes.csv" --benchmark_out_format=csv
"$build/bin/bench_step" --benchmark_out="$results/step.csv" --benchmark_out_format=csv | tee "$results/step.txt"
