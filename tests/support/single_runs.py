"""Runs of the program on one core without mpirun, with their time series as arrays; closed forms that contact is held against."""

import csv
import math
import pathlib
import subprocess

import h5py
import numpy

from driver import SKEIN, DriverTest

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"


class SingleRuns(DriverTest):
    def run_alone(self, out, *settings, scene=None, expect=0):
        """Runs a scene with key=value settings; what it printed."""
        arguments = [SKEIN, "run", str(scene or self.scene), "--out", str(self.directory / out), "--threads", "1", "--quiet", "--overwrite"]
        for setting in settings:
            arguments += ["--set", setting]
        done = subprocess.run(arguments, capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def series(self, out):
        """Columns of the time series by their names, without units."""
        with open(self.directory / out / "observables.csv", newline="") as file:
            rows = list(csv.reader(file))
        table = numpy.array(rows[1:], dtype=float)
        return {name.split("[")[0]: table[:, i] for i, name in enumerate(rows[0])}

    def state(self, out):
        """Of the last checkpoint: {group: {dataset: array}}."""
        newest = sorted((self.directory / out).glob("checkpoint_*.h5"))[-1]
        with h5py.File(newest) as file:
            return {group: {name: data[:] for name, data in file[f"groups/{group}"].items() if isinstance(data, h5py.Dataset)} for group in file["groups"]}


def restitution_of_share(share):
    """Of m x'' = -max(0, k x + c x') by c/(2 sqrt(k m)): the contact lets go when it would begin to pull."""
    if share == 1:
        return math.exp(-2)
    if share < 1:
        return math.exp(-2 * share * math.acos(share) / math.sqrt(1 - share**2))
    return math.exp(-2 * share * math.acosh(share) / math.sqrt(share**2 - 1))
