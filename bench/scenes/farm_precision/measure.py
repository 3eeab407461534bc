#!/usr/bin/env python3
"""Tables of the farm's error against work: measure.py OUT RESULTS

Reads the runs of run.py in OUT and writes into RESULTS
  farm_precision.csv   error of the tips' orbits over elements and clamp, with the time that the whole farm would take;
  farm_phases.csv      phases and repetition, and what they depend on;
  farm_kinds.csv       the 600 kinds of cilia: magnetisation, deviation of the phase, when they have forgotten the start.
Needs numpy and h5py. bench/plots/farm_precision.py draws the tables.
"""

import argparse
import csv
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import cell
from cell import FRAMES, beat

MACHINE = re.search(r"^model name[^:]*: *(.*)$", Path("/proc/cpuinfo").read_text(), re.M)


def write(path, rows):
    with open(path, "w", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)


def mean(values, weight):
    """Over frames and the farm's cilia."""
    return np.average(values if values.ndim == 1 else values.mean(axis=0), weights=weight)


def precision(out):
    """Rows over n: distance of tips from the reference in L, over the last turn (and in the first, which holds the start)."""
    tips = {name: cell.read(out / name)[1] for name in cell.ladder()}
    origin = cell.read(out / cell.REFERENCE)[2]
    weight = cell.weights(origin)
    reference = tips[cell.REFERENCE]

    def rms(values, frames):
        square = np.sum((values - reference)[frames] ** 2, axis=2)
        return np.sqrt(mean(square, weight))

    first, last = slice(1, FRAMES + 1), slice(FRAMES + 1, None)
    rows = []
    for clamp, ns in cell.LADDER.items():
        order = 1 if clamp == "clamped_frozen" else 2
        for n in ns:
            name, half = f"{clamp}_{n}", f"{clamp}_{n // 2}"
            extrapolated = n % 2 == 0 and half in tips
            summary = json.loads((out / name / "summary.json").read_text())
            core = float((out / name / "core_seconds").read_text())
            rows.append({
                "clamp": clamp, "n": n, "dt": f"{summary['dt_s']:.9g}", "steps": summary["steps"],
                "error": f"{rms(tips[name], last):.4g}",
                "error_max": f"{np.linalg.norm((tips[name] - reference)[last], axis=2).max():.4g}",
                "error_first_turn": f"{rms(tips[name], first):.4g}",
                "richardson_error": f"{rms(tips[name] + (tips[name] - tips[half]) / (2**order - 1), last):.4g}" if extrapolated else "",
                "core_seconds": f"{core:.4g}",
                "farm_core_seconds": f"{core * weight.sum() / len(weight):.4g}",
                "farm_element_steps": f"{summary['element_steps'] * weight.sum() / len(weight):.4g}",
                "digest": summary["digest"],
                "machine": MACHINE[1] if MACHINE else "",
            })
    return rows


def settled(out):
    """Time from which the first turn comes back in the second, of every cilium, s, and the period."""
    period = abs(beat.period_of(out))
    time, tips, _ = cell.read(out)
    change = np.linalg.norm(tips[FRAMES:2 * FRAMES + 1] - tips[:FRAMES + 1], axis=2)
    return beat.repeats_from(SimpleNamespace(change=change, time=time[FRAMES:2 * FRAMES + 1], period=period)), period


def deviations(turn, weight):
    """Lag of the farm behind the couple, and what every cilium adds to it, degrees; nan for those that hardly move."""
    a = beat.fundamental(turn)
    ratio = np.exp(1j * np.where(np.abs(a) > beat.STILL, np.angle(a / beat.expected_phase(turn)), np.nan))
    together = np.nansum(weight * ratio)
    return -beat.degrees(together), beat.degrees(ratio / together)


def phases(out):
    orbit = cell.read(out / "farm")[1][-FRAMES:]
    rows = []
    for name in cell.variations():
        turn = beat.read_turn(out / name, beat.period_of(out / name))
        weight = cell.weights(turn.origin)
        lag, deviation = deviations(turn, weight)
        beating = np.isfinite(deviation)
        start, period = settled(out / name)
        by_time = np.argsort(start)
        share = np.cumsum(weight[by_time]) / weight.sum()
        rows.append({
            "case": name,
            "lag_deg": f"{lag:.3f}",
            "deviation_rms_deg": f"{np.sqrt(np.average(deviation[beating] ** 2, weights=weight[beating])):.4g}",
            "deviation_max_deg": f"{np.nanmax(np.abs(deviation)):.4g}",
            "repeats_90_percent_turns": f"{start[by_time[np.searchsorted(share, 0.9)]] / period:.4f}",
            "repeats_all_turns": f"{start.max() / period:.4f}",
            "third_turn_change_max_L": f"{turn.change.max():.2g}",
            "orbit_from_farm_max_L": f"{np.linalg.norm(turn.displacement[1:] - orbit, axis=2).max():.2g}",
        })
    return rows


def every_kind(out):
    turn = beat.read_turn(out / "farm", cell.PERIOD)
    weight = cell.weights(turn.origin)
    _, deviation = deviations(turn, weight)
    start, _ = settled(out / "farm")
    amplitude = np.abs(beat.fundamental(turn))
    m = np.round(turn.magnetisation, 6) + 0.0  # no negative zeros
    return [{"x": x, "y": y, "cilia": weight[k], "m_x": m[k, 0], "m_y": m[k, 1], "m_z": m[k, 2], "fundamental_L": f"{amplitude[k]:.4f}",
             "deviation_deg": f"{deviation[k]:.3f}", "repeats_from_s": f"{start[k]:g}"}
            for k, (x, y) in enumerate(cell.kinds(turn.origin))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("results", type=Path)
    arguments = parser.parse_args()
    for name, table in (("precision", precision), ("phases", phases), ("kinds", every_kind)):
        write(arguments.results / f"farm_{name}.csv", table(arguments.out))


if __name__ == "__main__":
    main()
