"""Many runs of one scene: skein.sweep("scene.toml", {"rods.arm.shape.elements": [10, 20, 40], "time.dt": [1e-4, 5e-5]})."""

import itertools
import json
import os
import shlex
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from . import notebook
from .program import RunFailed, as_file, command, is_text, run

JOB = """#!/usr/bin/env bash
#SBATCH --job-name={name}
#SBATCH --array=1-{count}
#SBATCH --cpus-per-task={threads}
#SBATCH --output={folder}/job_%a.log
exec bash -c "$(sed -n "${{SLURM_ARRAY_TASK_ID}}p" {commands})"
"""


class Table(list):
    """Rows of a sweep, one dict a run: the swept keys, `out`, `digest`, `wall_s`, the observables at the end by their headings, and what `measure` gave; a
    run that failed has `error` instead."""

    def __init__(self, rows=(), keys=()):
        super().__init__(rows)
        self.keys_swept = tuple(keys)

    def __repr__(self):
        """A line a run: what was swept, and the digest or the error."""
        lines = ["  ".join([*(f"{key} = {row.get(key)}" for key in self.keys_swept), str(row["out"]),
                            f"error: {str(row['error']).splitlines()[0][:100]}" if "error" in row else f"digest {row.get('digest')}"]) for row in self]
        return "\n".join([f"<Table of {len(self)} runs, {sum('error' in row for row in self)} failed or not ended>", *lines])

    def _repr_html_(self):
        results = sorted({key for row in self for key in row} - {*self.keys_swept, "out", "digest", "finished", "wall_s", "error"})
        heading = ["out", *self.keys_swept, "wall_s", *results, "error"]
        return notebook.table(f"Sweep of {len(self)} runs", [[row.get(key) for key in heading] for row in self], heading)

    def to_pandas(self):
        import pandas
        return pandas.DataFrame(list(self))

    def column(self, name):
        return [row.get(name) for row in self]


def sweep(scene, keys, out=None, threads=1, at_once=None, measure=None, slurm=False, **fixed):
    """Runs a scene with every combination of the values of `keys`, in OUT/<number>; runs that have ended are left as they are, so the same call goes on.

    at_once     runs side by side; default: as many as the cores that this process may use bear, of `threads` each
    measure     {heading: function of the run's results}
    slurm       True: writes OUT/sweep.sbatch, an array of jobs, and submits it by sbatch; the same call then gathers what has ended. Raises
                FileNotFoundError where runs have not ended and there is no sbatch
    fixed       keys that all runs share
    """
    with as_file(scene) as path:
        out = Path(out or Path("out") / f"{path.stem}_sweep")
        out.mkdir(parents=True, exist_ok=True)
        cases = [dict(zip(keys, values)) for values in itertools.product(*keys.values())]
        names = [f"{number:0{len(str(len(cases)))}d}" for number in range(1, len(cases) + 1)]
        _same_sweep(out, names, cases)
        if slurm:
            if not shutil.which("sbatch") and not all((out / name / "summary.json").exists() for name in names):
                raise FileNotFoundError("sbatch is not in PATH, so no job can be submitted: call sweep on a login node of the cluster, or leave out slurm=True to run here")
            kept = path if isinstance(scene, (str, Path)) and not is_text(scene) else shutil.copy(path, out / path.name)
            _submit(out, Path(kept).resolve(), names, cases, fixed, threads)
            rows = [_row(out / name, case, measure) if (out / name / "summary.json").exists() else {**case, "out": str(out / name), "error": "not ended"} for name, case in zip(names, cases)]
        else:
            at_once = at_once or max(1, len(os.sched_getaffinity(0)) // threads)

            def one(name, case):
                try:
                    run(path, out / name, threads=threads, quiet=True, **{**fixed, **case})
                except RunFailed as failed:
                    return {**case, "out": str(out / name), "error": str(failed)}
                return _row(out / name, case, measure)

            with ThreadPoolExecutor(at_once) as workers:
                rows = list(workers.map(one, names, cases))
    return Table(rows, keys)


def _same_sweep(out, names, cases):
    """Keeps which number has which values; refuses a folder that holds another sweep."""
    now = json.loads(json.dumps({name: {key: getattr(value, "tolist", lambda value=value: value)() for key, value in case.items()} for name, case in zip(names, cases)}))
    file = out / "sweep.json"
    if file.exists() and json.loads(file.read_text()) != now:
        raise FileExistsError(f"{out} holds another sweep (sweep.json); give another `out`")
    file.write_text(json.dumps(now, indent=1) + "\n")


def _row(out, case, measure):
    from .results import open as results
    found = results(out)
    row = {**case, "out": str(out), **{key: found.summary.get(key) for key in ("digest", "finished", "wall_s")}, **found.summary.get("observables", {})}
    return row | {name: function(found) for name, function in (measure or {}).items()}


def _submit(out, scene, names, cases, fixed, threads):
    commands = out / "commands.txt"
    commands.write_text("".join(shlex.join(command("run", scene, {**fixed, **case}, "--out", (out / name).resolve(), "--threads", threads, "--quiet")) + "\n" for name, case in zip(names, cases)))
    job = out / "sweep.sbatch"
    known = job.exists()
    job.write_text(JOB.format(name=scene.stem, count=len(names), threads=threads, folder=out.resolve(), commands=commands.resolve()))
    if not known and shutil.which("sbatch"):
        try:
            subprocess.run(["sbatch", str(job)], check=True)
        except (OSError, subprocess.CalledProcessError):
            job.unlink()  # so that the same call submits it again
            raise
