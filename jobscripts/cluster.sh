# Sourced by the job scripts of batch systems, in the checkout: which program runs, whether it is right on these nodes, and how it is
# asked to stop.

skein=${SKEIN:-build/bin/skein}

# need_program PROGRAM [HOW TO BUILD IT]
need_program() {
    [[ -x $1 ]] || { echo "error: no program at '$1'; build it for these nodes first: ${2:-bash jobscripts/quickstart.sh --no-install --build-only}" >&2; exit 2; }
}

say() { echo "== $(date '+%F %T')  $*"; }

# run_until_asked COMMAND...: hands USR1 and TERM on to the command, as USR1. Then `code` is how it ended, and `asked` the last signal that
# came, if any.
run_until_asked() {
    local again run
    asked=
    "$@" &
    run=$!
    # mpirun hands USR1 on to every rank. A trap ends the shell's wait early, so it waits again for what mpirun has to say.
    again=no
    trap 'asked=USR1 again=yes; say "asked to stop"; kill -USR1 $run 2>/dev/null' USR1
    trap 'asked=TERM again=yes; say "told to end"; kill -USR1 $run 2>/dev/null' TERM
    wait $run
    code=$?
    while [[ $again == yes ]]; do
        again=no
        wait $run
        code=$?
    done
    trap '' USR1 TERM
    say "skein left with code $code"
}

# True where the run stopped with a checkpoint, or was asked to before it could listen; the same command then goes on.
is_unfinished() { ((code == 3 || code == 128 + $(kill -l USR1))); }

# Ends a job of Slurm with the code of its run; one that is unfinished goes back into the queue, SKEIN_RESTARTS times at most.
end_or_requeue() {
    if is_unfinished; then
        if ((${SLURM_RESTART_COUNT:-0} < ${SKEIN_RESTARTS:-100})); then
            echo "== back into the queue"
            scontrol requeue "$SLURM_JOB_ID" && exit 0
        fi
        echo "error: not finished, and not queued again; sbatch the same line to go on" >&2
    fi
    exit "$code"
}

# run_on_nodes SCENE [SKEIN OPTIONS...]: a job of Slurm that takes a scene as far as its time goes, on all that it was given.
run_on_nodes() {
    local scene=$1 threads=${SLURM_CPUS_PER_TASK:-1}
    shift
    need_program "$skein"
    say "job $SLURM_JOB_ID, start $((${SLURM_RESTART_COUNT:-0} + 1)), $SLURM_NTASKS ranks x $threads threads on $SLURM_JOB_NODELIST"
    # A build that computes wrong on one of these nodes must not run there.
    mpirun -n "$SLURM_NNODES" --map-by ppr:1:node --bind-to none "$skein" check --self --threads 1 || exit 4
    # mpirun takes hosts and slots from Slurm; each rank gets its own cores. Where Open MPI is built with Slurm's PMIx, this does the same:
    #   srun --mpi=pmix --cpus-per-task="$threads" --cpu-bind=cores "$skein" run ...
    run_until_asked mpirun -n "$SLURM_NTASKS" --map-by "slot:PE=$threads" --bind-to core "$skein" run "$scene" --threads "$threads" "$@"
    end_or_requeue
}
