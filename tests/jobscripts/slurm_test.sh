#!/usr/bin/env bash
# The scripts of jobscripts/slurm on a Slurm of one node, made here for the purpose, with small scenes. The table is the folder: a script that
# has no function job_NAME here fails the test. Some three minutes, so it is run by hand:
#
#   apt-get install slurm-wlm munge && bash tests/jobscripts/slurm_test.sh [BUILD_DIR [NAME...]]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(realpath "${1:-$root/build}")
shift $(($# > 0))
export SKEIN=$build/bin/skein NETCAL=$build/bin/netcal
carpet=$root/apps/cilia_carpet/carpet_8x8.toml

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }
for program in munged slurmctld slurmd sbatch; do
    PATH=$PATH:/usr/sbin command -v $program >/dev/null || skip "no $program; apt-get install slurm-wlm munge"
done
((EUID == 0)) || skip "slurmd needs root to start jobs"
(($(nproc) >= 2)) || skip "two cores are needed"
[[ -x $SKEIN ]] || fail "no program at $SKEIN; bash jobscripts/quickstart.sh --build-only"

# A cluster of its own: keys, sockets, ports, states, logs in one folder.
work=$(mktemp -d)
chmod 755 "$work"
host=$(hostname -s)
started=()
finish() {
    local code=$?
    scancel --user=root 2>/dev/null || true
    for process in "${started[@]}"; do kill "$process" 2>/dev/null || true; done
    wait "${started[@]}" 2>/dev/null || true
    if ((code == 0)); then rm -rf "$work"; else echo "kept: $work"; fi
}
trap finish EXIT

mkdir "$work/munge" "$work/state" "$work/spool"
head -c 1024 /dev/urandom >"$work/munge/key"
chmod 600 "$work/munge/key"
chown -R munge:munge "$work/munge"
setpriv --reuid=munge --regid=munge --clear-groups munged --foreground --key-file="$work/munge/key" --socket="$work/munge/socket" \
    --pid-file="$work/munge/pid" --log-file="$work/munge/log" --seed-file="$work/munge/seed" >/dev/null 2>&1 &
started+=($!)

cat >"$work/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket,cred_expire=5
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
KillWait=5
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000
PartitionName=main Nodes=ALL Default=YES
CONF
export SLURM_CONF=$work/slurm.conf
PATH=$PATH:/usr/sbin
for ((i = 0; i < 50; ++i)); do [[ -S $work/munge/socket ]] && break; sleep 0.1; done
slurmctld -D -f "$SLURM_CONF" >/dev/null 2>&1 &
started+=($!)
slurmd -D -f "$SLURM_CONF" >/dev/null 2>&1 &
started+=($!)
for ((i = 0; i < 60; ++i)); do [[ $(sinfo -h -o %t 2>/dev/null) == idle ]] && break; sleep 0.5; done
[[ $(sinfo -h -o %t) == idle ]] || fail "the node does not come up; see $work/slurmd.log"

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
field() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^\",]*\).*/\1/p" "$work/$1/summary.json"; }
state_of() {
    local state
    state=$(squeue -h -j "$1" -o %T 2>/dev/null) || state=
    [[ -n $state ]] || state=$(scontrol show job "$1" | sed -n 's/ *JobState=\([A-Z_]*\).*/\1/p' | sort -u)
    echo "$state"
}
# submit LOG OPTIONS... SCRIPT ARGUMENTS...: from the checkout, as the scripts say; prints the number of the job.
submit() { (cd "$root" && sbatch --parsable --cpus-per-task=1 --hint=multithread --output="$work/$1" "${@:2}"); }
# finished JOB [STATE]: waits until the job is over; true where it ended so.
finished() {
    local state=
    for ((i = 0; i < 400; ++i)); do
        state=$(state_of "$1")
        case $state in COMPLETED | FAILED | TIMEOUT | CANCELLED | NODE_FAIL) break ;; esac
        sleep 0.5
    done
    [[ $state == "${2:-COMPLETED}" ]] || { echo "job $1 is $state" >&2; return 1; }
}
same_digest() { [[ $(field "$1" steps) == "$(field "$2" steps)" && $(field "$1" digest) == "$(field "$2" digest)" ]] || fail "$1: $(field "$1" steps) steps, digest $(field "$1" digest); $2: $(field "$2" steps) steps, digest $(field "$2" digest)"; }
wait_for() { # what, command...
    for ((i = 0; i < 200; ++i)); do "${@:2}" 2>/dev/null && return; sleep 0.2; done
    fail "$1 does not come"
}
has_checkpoint() { compgen -G "$work/$1/checkpoint_*.h5" >/dev/null; }
quiet_outputs=(--set output.checkpoint=0 --set output.trajectory=0 --set output.tips=0 --set output.series=0)

# The scripts of the other cases go on as that of the cilia does: a scene of theirs, whole and in two jobs.
in_two_jobs() { # NAME SCENE OPTIONS...
    local name=$1 scene=$2 code=0 id
    shift 2
    mpirun -n 2 "$SKEIN" run "$scene" "$@" --steps 400 --out "$work/$name.whole" --quiet || fail "$name by itself"
    for steps in 150 400; do
        id=$(submit "$name.log" --ntasks-per-node=2 --time=10 "$script" "$scene" "$@" --steps "$steps" --out "$work/$name.parts" --quiet)
        finished "$id" || { cat "$work/$name.log"; fail "$name, to step $steps"; }
    done
    same_digest "$name.parts" "$name.whole"
}
job_pit() { in_two_jobs pit "$root/apps/active_matter/pit_96.toml"; }
job_swarm() { in_two_jobs swarm "$root/apps/millipede/one_bot.toml"; }

# A job that meets its time limit goes back into the queue; one that is killed with all its processes is submitted again.
job_cilia() {
    local long=(--set time.duration=7.2e5 "${quiet_outputs[@]}" --set output.checkpoint_wall=3) code=0 id steps state
    # As far as 30 s of this machine go, without interruption.
    mpirun -n 2 "$SKEIN" run "$carpet" "${long[@]}" --out "$work/reference" --walltime 30 --quiet 2>"$work/reference.log" || code=$?
    ((code == 3)) || fail "the reference left with code $code"
    steps=$(field reference steps)

    # One minute, with the signal 50 s before its end: Slurm looks every half minute, so it comes within 30 s. The second start gets the
    # time it needs.
    id=$(submit job.log --ntasks-per-node=2 --time=1 --signal=B:USR1@50 "$script" "$carpet" "${long[@]}" --out "$work/job" --steps "$steps" --quiet)
    for ((i = 0; i < 300; ++i)); do
        state=$(state_of "$id")
        if [[ $state == PENDING ]] && grep -q 'left with code 3' "$work/job.log" 2>/dev/null; then scontrol update JobId="$id" TimeLimit=10 StartTime=now; fi
        case $state in COMPLETED | FAILED | TIMEOUT | CANCELLED | NODE_FAIL) break ;; esac
        sleep 1
    done
    cat "$work/job.log"
    [[ $state == COMPLETED ]] || fail "the job is $state"
    grep -q 'skein left with code 3' "$work/job.log" || fail "the job was never stopped by its limit"
    same_digest job reference

    local line=(--ntasks-per-node=2 --time=10 "$script" "$carpet" "${long[@]}" --out "$work/killed" --steps "$steps" --quiet)
    id=$(submit killed.log "${line[@]}")
    wait_for "a checkpoint" has_checkpoint killed
    scancel --signal=KILL --full "$id"
    finished "$id" CANCELLED || finished "$id" FAILED || fail "the job was not killed"
    [[ ! -e $work/killed/summary.json || $(field killed steps) != "$steps" ]] || fail "the job was killed too late"
    id=$(submit killed.log "${line[@]}")
    finished "$id" || fail "the successor of a killed job"
    same_digest killed reference
}

# Two seeds; the first is asked to stop and goes back into the queue.
job_nest() {
    local small=(--set output.checkpoint_wall=2 --set output.checkpoint=0 --steps 100000 --quiet) scene=$root/apps/nest/nest_110.toml id seed
    export SKEIN_OUT=$work/nests
    id=$(submit nest-%a.log --array=1-2 --ntasks=1 --time=10 "$script" "$scene" "${small[@]}")
    wait_for "a checkpoint" has_checkpoint nests/nest_110_seed1
    scancel --signal=USR1 --batch "${id}_1"
    wait_for "the stop" grep -q 'back into the queue' "$work/nest-1.log"
    # Slurm holds a job that comes back for two minutes; now will do.
    wait_for "the return" bash -c "[[ \$(squeue -h -j ${id}_1 -o %T) == PENDING ]]"
    scontrol update JobId="${id}_1" StartTime=now
    finished "${id}_1" && finished "${id}_2" || { cat "$work"/nest-*.log; fail "the array"; }
    for seed in 1 2; do
        "$SKEIN" run "$scene" "${small[@]}" --threads 1 --set "rods.0.placement.seed=$seed" --out "$work/nest_reference_$seed"
        same_digest "nests/nest_110_seed$seed" "nest_reference_$seed"
    done
    [[ $(field nest_reference_1 digest) != "$(field nest_reference_2 digest)" ]] || fail "the seed is without effect"
    unset SKEIN_OUT
}

job_scaling() {
    local id
    id=$(submit scaling.log --ntasks-per-node=2 --time=10 "$script" --counts 32 32 --repeats 1 --csv "$work/scaling.csv") # digests are compared in there
    finished "$id" || { cat "$work/scaling.log"; fail "scaling"; }
    (($(wc -l <"$work/scaling.csv") == 9)) || fail "rows of the table: $(wc -l <"$work/scaling.csv")" # two studies, protocols and layouts
}

job_netcal() {
    local id
    [[ -x $NETCAL ]] || { echo "left out: no $NETCAL"; return; }
    id=$(submit netcal.log --nodes=1 --ntasks-per-node=2 --time=10 "$script" --out "$work/machine.toml")
    finished "$id" || { cat "$work/netcal.log"; fail "netcal"; }
    grep -q '^latency_s = [0-9.e-]*$' "$work/machine.toml" || fail "the machine file: $(cat "$work/machine.toml")"
}

for script in "$root"/jobscripts/slurm/*; do
    name=$(basename "$script" .sbatch)
    declare -F "job_$name" >/dev/null || fail "jobscripts/slurm/$(basename "$script") has no row here"
    (($# == 0)) || [[ " $* " == *" $name "* ]] || continue
    began=$SECONDS
    "job_$name"
    echo "passed: $name, $((SECONDS - began)) s"
done
