#!/usr/bin/env bash
# jobscripts/slurm/cilia.sbatch on a Slurm of one node, made here for the purpose: a job that meets its time limit writes a checkpoint,
# goes back into the queue, and ends with the digest of an uninterrupted run. Two to three minutes, so it is run by hand:
#
#   apt-get install slurm-wlm munge && bash tests/jobscripts/slurm_test.sh [BUILD_DIR]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
export SKEIN=${1:-$root/build}/bin/skein
job=$root/jobscripts/slurm/cilia.sbatch
scene=$root/apps/cilia_carpet/carpet_8x8.toml

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
    for process in "${started[@]}"; do kill "$process" 2>/dev/null || true; done
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
cd "$work"
long=(--set time.duration=7.2e5 --set output.checkpoint=7200 --set output.trajectory=0 --set output.tips=0 --set output.series=0)

# As far as 40 s of this machine go, without interruption.
code=0
mpirun -n 2 "$SKEIN" run "$scene" "${long[@]}" --out reference --walltime 40 --quiet 2>reference.log || code=$?
((code == 3)) || fail "the reference left with code $code"
steps=$(field reference steps)
echo "reference: $steps steps, digest $(field reference digest)"

# One minute, with the signal 50 s before its end: Slurm looks every half minute, so it comes within 30 s. The second start gets the
# time it needs.
id=$(sbatch --parsable --ntasks-per-node=2 --cpus-per-task=1 --hint=multithread --time=1 --signal=B:USR1@50 --output="$work/job.log" \
    "$job" "$scene" "${long[@]}" --out job --steps "$steps" --quiet)
for ((i = 0; i < 300; ++i)); do
    state=$(squeue -h -j "$id" -o %T 2>/dev/null) || state=
    [[ -n $state ]] || state=$(scontrol show job "$id" | sed -n 's/ *JobState=\([A-Z]*\).*/\1/p')
    if [[ $state == PENDING ]] && grep -q 'left with code 3' job.log 2>/dev/null; then scontrol update JobId="$id" TimeLimit=10; fi
    case $state in COMPLETED | FAILED | TIMEOUT | CANCELLED | NODE_FAIL) break ;; esac
    sleep 1
done
cat job.log
[[ $state == COMPLETED ]] || fail "the job is $state"
stops=$(grep -c 'skein left with code 3' job.log) || true
((stops >= 1)) || fail "the job was never stopped by its limit"
[[ $(field job steps) == "$steps" && $(field job digest) == "$(field reference digest)" ]] ||
    fail "job: $(field job steps) steps, digest $(field job digest)"
echo "passed: stopped $stops time(s) by the limit, $(field job steps) steps, digest $(field job digest)"
