#!/usr/bin/env bash
# jobscripts/pbs as PBS starts them: by bash, in the home directory, with PBS_* variables and a node file; no PBS is needed. A job runs to its
# end; one whose time is up leaves a checkpoint and submits its successor, which ends with the digest of an uninterrupted run.
#
#   pbs_test.sh SKEIN
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
SKEIN=$(realpath "$1")
carpet=$root/apps/cilia_carpet/carpet_8x8.toml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAILED: $*" >&2; cat "$work"/*.log >&2; exit 1; }
cores=$(lscpu --parse=CORE,SOCKET | grep -v '^#' | sort -u | wc -l)
((cores >= 2)) || { echo "skipped: two cores are needed"; exit 77; } # the script gives each rank its own
field() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^\",]*\).*/\1/p" "$work/$1/summary.json"; }

# The table is the folder.
[[ $(cd "$root/jobscripts/pbs" && echo *) == cilia.pbs ]] || fail "a script of jobscripts/pbs has no test here"
script=$root/jobscripts/pbs/cilia.pbs

# What PBS gives: a node file with a line for each rank; qsub, which writes down what it is told; qstat, which folds long lines.
mkdir "$work/bin" "$work/home"
printf '%s\n' localhost localhost >"$work/nodes"
cat >"$work/bin/qsub" <<'QSUB'
#!/usr/bin/env bash
printf '%s\n' "$@" >"$FAKE/qsub.arguments"
env >"$FAKE/qsub.environment"
echo 2.test
QSUB
cat >"$work/bin/qstat" <<'QSTAT'
#!/usr/bin/env bash
[[ "$*" == "-f 1.test" ]] || exit 1
printf 'Job Id: 1.test\n    Job_Name = cilia\n    Resource_List.place = scatter:excl\n'
printf '    Resource_List.select = 1:ncpus=2:mpiprocs=2:\n\tompthreads=1\n    Resource_List.walltime = %s\n' "$FAKE_WALLTIME"
QSTAT
chmod +x "$work/bin/qsub" "$work/bin/qstat"

# job LOG VARIABLE=VALUE...: the script from a copy, as PBS has it; prints its code.
job() {
    local log=$1 code=0
    shift
    cp "$script" "$work/spool"
    (cd "$work/home" && env -u SKEIN PBS_ENVIRONMENT=PBS_BATCH PBS_JOBID=1.test PBS_JOBNAME=cilia PBS_QUEUE=short PBS_O_WORKDIR="$root" PBS_NODEFILE="$work/nodes" \
        OMP_NUM_THREADS=1 NCPUS=2 FAKE="$work" SKEIN="$SKEIN" SCENE="$carpet" "$@" bash "$work/spool") >"$work/$log" 2>&1 || code=$?
    echo "$code"
}

# To its end, on two ranks, with and without a qstat to ask.
options="--set output.trajectory=0 --set output.tips=0 --quiet"
code=$(job end.log OPTIONS="$options --steps 2000 --out $work/end")
[[ $code == 0 && $(field end steps) == 2000 && $(field end ranks) == 2 && $(field end threads) == 1 ]] || fail "the job left with code $code"
code=$(job known.log PATH="$work/bin:$PATH" FAKE_WALLTIME=04:00:00 OPTIONS="$options --steps 2000 --out $work/known")
[[ $code == 0 && $(field known digest) == "$(field end digest)" && ! -e $work/qsub.arguments ]] || fail "the job left with code $code, digest $(field known digest)"

# The time is up after some seconds; the successor is the script with the variables that qsub was given.
options="--set time.duration=7.2e5 --set output.trajectory=0 --set output.tips=0 --set output.series=0 --set output.checkpoint=0 --quiet --out $work/long"
code=$(job limit.log PATH="$work/bin:$PATH" FAKE_WALLTIME=00:02:04 OPTIONS="$options")
[[ $code == 0 ]] || fail "the job that submits its successor left with code $code"
grep -q 'skein left with code 3' "$work/limit.log" || fail "the job was not stopped by its limit"
told=$(paste -s -d ' ' "$work/qsub.arguments")
[[ $told == "-W depend=afterany:1.test -N cilia -q short -l select=1:ncpus=2:mpiprocs=2:ompthreads=1 -l place=scatter:excl -l walltime=00:02:04 -v SKEIN_START,SCENE,OPTIONS,THREADS,SKEIN,SKEIN_RESTARTS jobscripts/pbs/cilia.pbs" ]] ||
    fail "qsub was told: $told"
reached=$(field long steps)
steps=$((reached + 3000))
passed=()
for name in SKEIN_START SCENE THREADS SKEIN SKEIN_RESTARTS; do passed+=("$(grep "^$name=" "$work/qsub.environment")"); done
code=$(job successor.log "${passed[@]}" OPTIONS="$(sed -n 's/^OPTIONS=//p' "$work/qsub.environment") --steps $steps")
[[ $code == 0 ]] || fail "the successor left with code $code"
grep -q 'start 2,' "$work/successor.log" || fail "the successor does not count"
"$SKEIN" run "$carpet" ${options/$work\/long/$work\/whole} --threads 1 --steps "$steps" >"$work/whole.log" 2>&1
[[ $(field long steps) == "$steps" && $(field long first_step) == "$reached" && $(field long digest) == "$(field whole digest)" ]] ||
    fail "the successor: steps $(field long first_step) to $(field long steps), digest $(field long digest), not $(field whole digest)"

# There is an end to successors; a job that is deleted has none; one that is asked to stop has one.
rm "$work/qsub.arguments"
code=$(job last.log PATH="$work/bin:$PATH" FAKE_WALLTIME=00:02:03 SKEIN_RESTARTS=1 SKEIN_START=2 OPTIONS="${options/$work\/long/$work\/last}")
[[ $code == 3 && ! -e $work/qsub.arguments ]] || fail "code $code after the last start"
for signal in TERM USR1; do
    rm -f "$work/qsub.arguments"
    (
        for ((i = 0; i < 300; ++i)); do [[ -e $work/$signal/.lock ]] && break; sleep 0.1; done
        sleep 1
        for process in $(ps -eo pid=,args= | awk -v script="bash $work/spool" '$2 " " $3 == script { print $1 }'); do kill -"$signal" "$process"; done
    ) &
    code=$(job "$signal.log" PATH="$work/bin:$PATH" FAKE_WALLTIME=04:00:00 OPTIONS="${options/$work\/long/$work\/$signal}")
    wait
    if [[ $signal == TERM ]]; then
        [[ $code == 3 && ! -e $work/qsub.arguments ]] || fail "code $code after TERM"
    else
        [[ $code == 0 && -e $work/qsub.arguments ]] || fail "code $code after USR1"
    fi
    compgen -G "$work/$signal/checkpoint_*.h5" >/dev/null || fail "no checkpoint after $signal"
done

# A line of the node file for each core, as Torque writes it.
code=$(job torque.log PBS_NUM_PPN=2 PBS_WALLTIME=14400 THREADS=2 OMP_NUM_THREADS= OPTIONS="--set output.trajectory=0 --set output.tips=0 --quiet --steps 2000 --out $work/torque")
[[ $code == 0 && $(field torque ranks) == 1 && $(field torque threads) == 2 && $(field torque digest) == "$(field end digest)" ]] || fail "as Torque starts it: code $code"
echo "passed: runs to their end, the limit, the successor, the last one, signals, Torque"
