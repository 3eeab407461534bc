#!/usr/bin/env python3
"""How much less work an error takes: work_at_error.py TABLE [ERROR ...]

Reads the table of `bench_work_precision --csv TABLE` and prints, for the errors asked for (default: 0.03 0.01 0.001), the element-steps
of the published configuration over those of Skein's default, case by case over the ladder of n, then their geometric mean and range.
Between two rungs work is interpolated as a power of the error. `*`: the published error was extrapolated beyond its finest rung by the
slope of its last two. `>`: the default's coarsest rung is better than the error asked for, and is what counts. Needs numpy.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from work_precision import read  # noqa: E402  (after the path)

CLAMPED = ("timoshenko", "euler_buckling", "cilium", "torsional_wave", "bending_mode_0", "large_rotation", "bend", "magnetised", "bending_mode_1")
FREE = ("axial_stretching", "catenary", "axial_wave")  # no clamp carries a moment
FAR = ("helical_buckling",)  # the clamps are far from what is looked at


def work_at(curve, error):
    """Element-steps for `error`, and a mark that says how they were found."""
    errors, works = (np.log(curve.column(key)) for key in ("error", "element_steps"))
    wanted = np.log(error)
    if errors[0] <= wanted:
        return np.exp(works[0]), ">"
    for i in range(1, len(errors)):
        if errors[i] <= wanted or i == len(errors) - 1:
            slope = (works[i] - works[i - 1]) / (errors[i] - errors[i - 1])
            return np.exp(works[i] + slope * (wanted - errors[i])), "" if errors[i] <= wanted else "*"
    raise ValueError(f"one rung of {curve.name} makes no curve")


def ratio(curves, error):
    (base, base_mark), (published, mark) = work_at(curves[0], error), work_at(curves[-1], error)
    return published / base, "".join(sorted({base_mark, mark} - {""}))


def print_cases(title, names, cases, errors):
    print(f"\n| {title} | " + " | ".join(f"at {error:.3g}" for error in errors) + " |")
    print("|---" * (len(errors) + 1) + "|")
    rows = {name: [ratio(cases[name], error) for error in errors] for name in names if name in cases}
    for name, row in rows.items():
        print(f"| {name} | " + " | ".join(f"{value:.3g}{mark}" for value, mark in row) + " |")
    if len(rows) > 1:
        values = np.array([[value for value, _ in row] for row in rows.values()])
        print("| geometric mean | " + " | ".join(f"{m:.3g}" for m in np.exp(np.log(values).mean(axis=0))) + " |")
        print("| range | " + " | ".join(f"{low:.3g} to {high:.3g}" for low, high in zip(values.min(axis=0), values.max(axis=0))) + " |")


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    errors = [float(text) for text in sys.argv[2:]] or [0.03, 0.01, 0.001]
    cases = read(sys.argv[1])
    for title, names in (("a clamp carries a moment", CLAMPED), ("no clamp's moment", FREE), ("far from the clamps", FAR)):
        print_cases(title, names, cases, errors)


if __name__ == "__main__":
    main()
