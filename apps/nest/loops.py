#!/usr/bin/env python3
"""What a lid does to a bed of rods, cycle by cycle: loops.py RUN [--area M2]

Reads observables.csv, physics.json and summary.json of a run, prints a table and writes RUN/loops.json. Needs numpy.

  stress      sigma_lid = F_lid/A, sigma_base = F_base/A - weight/A: what the lid brings to the base. F: sums of normal forces
  strain      (H0 - H)/H0, H0: height of the lid when it first touches a rod
  cycle       from where the base stress leaves the servo's lower bar (cycle 1) or the lid turns forth, over the peak, where it turns
              back, to where it turns forth again
  psi         D/W_in = 1 - W_out/W_in: W_in what the lid does to the rods on its way forth, W_out what it gets back
  residual    loss of height over a cycle, between its ends, which have the same base stress
  friction    what contacts and walls lose beyond their dashpots: from the rods' energies where the run was audited (output.audit), else as they
              say (friction_work); drag: what the rods' own damping takes
  z           2 contacts/rods, contacts counted by pairs of elements; mean of 11 rows
"""

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy")
import numpy as np  # noqa: E402

import skein  # noqa: E402

AROUND = 5  # rows on each side over which z is meaned
ELASTIC = "elastic_stretch[J]", "elastic_shear[J]", "elastic_bend[J]", "elastic_twist[J]"
KINETIC = "kinetic_translation[J]", "kinetic_rotation[J]"


@dataclass
class Run:
    directory: Path
    column: dict   # by heading, arrays of one length
    physics: dict
    summary: dict  # empty while it runs
    lid: dict      # the wall that has a servo
    area: float    # of the base, m^2

    def __getitem__(self, heading):
        needs.need_names(self.directory, "columns of observables.csv called", self.column, [heading], "the scene is not a bed of rods under a lid")
        return self.column[heading]

    def sum(self, headings):
        return sum(self[heading] for heading in headings)

    @property
    def time(self):
        return self["time[s]"]

    @property
    def height(self):
        return self[self.lid["name"] + "_height[m]"]

    @property
    def work(self):
        """Of the lid on the rods, J."""
        return self[self.lid["name"] + "_work[J]"]

    @property
    def lid_force(self):
        return self[self.lid["name"] + "_force[N]"]

    @property
    def turns(self):
        return self[self.lid["name"] + "_turns[-]"].astype(int)

    @property
    def weight(self):
        """Of all rods, N: potential energy over height, which gravity along z makes one number."""
        return self["potential[J]"][0] / self["centre_z[m]"][0]

    @property
    def lid_stress(self):
        return self.lid_force / self.area

    @property
    def base_stress(self):
        return (self[self.lid["servo"]["watch"] + "_force[N]"] - self.weight) / self.area

    @property
    def low_stress(self):
        """Base stress at which the lid turns forth, above that of the weight."""
        return self.lid["servo"]["turn_forth_below"] - self.weight / self.area

    @property
    def top_stress(self):
        return self.lid["servo"]["turn_back_above"] - self.weight / self.area


def read(directory, area=None):
    found = skein.open(directory)
    directory, physics, summary = found.directory, found.physics, found.summary
    series = found.series
    column = {heading: series[heading] for heading in series.headings}
    lids = [wall for wall in physics.get("wall", []) if wall.get("servo", {}).get("speed", 0) > 0]
    if not lids:
        raise SystemExit(f"{directory}: no wall of this scene has a servo, so there is no lid to measure")
    return Run(directory, column, physics, summary, lids[0], area or lids[0]["servo"]["area"])


@dataclass
class Moment:
    """Where a cycle begins, peaks or ends; the lid turns between rows row - 1 and row."""
    row: int
    height: float  # m
    work: float    # of the lid until then, J


def turn(run, number):
    row = int(np.argmax(run.turns >= number))
    sign = -1 if number % 2 else 1  # heights are least at odd turns
    way = run.lid["servo"]["speed"] * (run.time[row] - run.time[row - 1])
    height = 0.5 * (run.height[row - 1] + run.height[row] + sign * way)
    # From either row with its force, for lack of another.
    work = np.mean([run.work[i] + run.lid_force[i] * (run.height[i] - height) for i in (row - 1, row)])
    return Moment(row, float(height), float(work))


def first_touch(run):
    touching = np.flatnonzero(run.lid_force > 0)
    if not len(touching):
        raise SystemExit(f"{run.directory}: the lid has touched no rod yet")
    return int(touching[0])


def cycles(run):
    """[(start, peak, end)] of all that are complete."""
    found = []
    for k in range(run.turns[-1] // 2):
        peak, end = turn(run, 2 * k + 1), turn(run, 2 * k + 2)
        if k == 0:
            low = np.flatnonzero(run.base_stress[:peak.row] < run.low_stress)
            row = int(low[-1])
            start = Moment(row, float(run.height[row]), float(run.work[row]))
        else:
            start = found[-1][2]
        found.append((start, peak, end))
    return found


def coordination(run, row):
    return float(np.mean(run["coordination[-]"][max(0, row - AROUND):row + AROUND + 1]))


def height_at(run, stress, until):
    """Where the base stress first passes a value on the way to a peak, m; none where it does not."""
    above = np.flatnonzero(run.base_stress[:until + 1] > stress)
    return float(run.height[above[0]]) if len(above) else None


def integral(of, over, first, last):
    part = slice(first, last + 1)
    return float(np.sum(0.5 * (of[part][1:] + of[part][:-1]) * np.diff(over[part])))


def budget(run, first, last=-1):
    """Energies between two rows, J.

    Loads and damping enter once: `dissipated` of the audit is the work of all loads, those of contacts among them, less what kinetic energy
    has gained: what damping of the rods alone takes. Contacts and walls have the energy that they store and their friction and viscous work in columns of their own.
    """
    last %= len(run.time)

    def change(headings):
        values = run.sum(headings)
        return float(values[last] - values[first])

    kinetic = run.sum(KINETIC)
    b = {"from_s": float(run.time[first]),
         "lid_work_J": change([run.lid["name"] + "_work[J]"]),
         "potential_loss_J": -change(["potential[J]"]),
         "kinetic_J": change(KINETIC),
         "elastic_J": change(ELASTIC),
         "contacts_and_walls_store_J": change(["contact_energy[J]", "wall_energy[J]"]),
         "friction_work_J": change(["contact_friction_work[J]", "wall_friction_work[J]"]),
         "viscous_work_J": change(["contact_viscous_work[J]", "wall_viscous_work[J]"])}
    b["audited"] = "dissipated[J]" in run.column
    if b["audited"]:
        b["rods_damping_J"] = change(["dissipated[J]"])
        # What contacts and walls did to the rods, from what these have and have lost; what they took from lid and springs and did not pass
        # on they lost.
        passed_on = b["kinetic_J"] + b["elastic_J"] + b["rods_damping_J"] - b["potential_loss_J"]
        b["friction_by_loads_J"] = b["lid_work_J"] - b["contacts_and_walls_store_J"] - passed_on - b["viscous_work_J"]
    else:
        if any(d["kind"] != "uniform" for d in run.physics["damping"]):
            raise SystemExit(f"{run.directory}: damping that is not uniform; run with output.audit = true")
        rate = sum(d["rate"] for d in run.physics["damping"])
        b["rods_damping_J"] = 2 * rate * integral(kinetic, run.time, first, last)
    gone = sum(b[key] for key in ("kinetic_J", "elastic_J", "contacts_and_walls_store_J", "friction_work_J", "viscous_work_J", "rods_damping_J"))
    b["defect_J"] = b["lid_work_J"] + b["potential_loss_J"] - gone
    b["defect_percent"] = 100 * b["defect_J"] / b["lid_work_J"]
    return b


def measure(run):
    touch = first_touch(run)
    h0 = float(run.height[touch])
    found = cycles(run)
    each = []
    for start, peak, end in found:
        w_in, w_out = peak.work - start.work, peak.work - end.work
        lost = budget(run, start.row, end.row)
        each.append({"start_height_m": start.height, "peak_height_m": peak.height, "end_height_m": end.height,
                     "peak_strain": (h0 - peak.height) / h0,
                     "peak_base_stress_Pa": float(np.max(run.base_stress[start.row:end.row + 1])),
                     "peak_lid_stress_Pa": float(np.max(run.lid_stress[start.row:end.row + 1])),
                     "work_in_J": w_in, "work_out_J": w_out, "psi": (w_in - w_out) / w_in,
                     "work_in_by_rows_J": -integral(run.lid_force, run.height, start.row, peak.row - 1),
                     "friction_J": lost.get("friction_by_loads_J", lost["friction_work_J"]), "dashpots_J": lost["viscous_work_J"],
                     "rods_damping_J": lost["rods_damping_J"],
                     "residual_m": start.height - end.height,
                     "z_low": coordination(run, start.row), "z_peak": coordination(run, peak.row)})
    phases = {name: phase["mean_s"] for name, phase in run.summary.get("phases", {}).items()}
    stepping = [phases.get(name, 0) for name in ("rods", "exchange", "search", "contacts")]
    loaded = slice(touch, None)
    return {"title": run.summary.get("title", run.directory.name), "rods": run.summary.get("rods"), "area_m2": run.area,
            "weight_stress_Pa": run.weight / run.area, "finished": bool(run.summary.get("finished", False)),
            "finite": bool(all(np.isfinite(values).all() for values in run.column.values())),
            "until_s": float(run.time[-1]), "H0_m": h0,
            "height_at_822_Pa_m": height_at(run, 822, found[0][1].row) if found else None,
            "z_settled": coordination(run, max(touch - 1, 0)), "cycles": each,
            "overlap_rods": float(np.max(run["max_overlap[-]"][loaded])), "overlap_walls": float(np.max(run["wall_overlap[-]"][loaded])),
            "budget": budget(run, touch), "rod_share": stepping[0] / sum(stepping) if sum(stepping) > 0 else None,
            "ns_per_element_step": run.summary.get("ns_per_element_step")}


COLUMNS = (("start", "mm", "start_height_m", 2), ("peak", "mm", "peak_height_m", 2), ("end", "mm", "end_height_m", 2), ("residual", "mm", "residual_m", 3),
           ("strain", "", "peak_strain", 3), ("base", "Pa", "peak_base_stress_Pa", 0), ("lid", "Pa", "peak_lid_stress_Pa", 0),
           ("in", "mJ", "work_in_J", 3), ("out", "mJ", "work_out_J", 3), ("psi", "", "psi", 4), ("friction", "mJ", "friction_J", 3),
           ("dashpots", "mJ", "dashpots_J", 3), ("drag", "mJ", "rods_damping_J", 3), ("z low", "", "z_low", 2), ("z peak", "", "z_peak", 2))


def table(f):
    lines = [f"{f['title']}: {len(f['cycles'])} cycles until {f['until_s']:.3f} s",
             f"lid touches at {1e3 * f['H0_m']:.2f} mm; weight {f['weight_stress_Pa']:.1f} Pa; z {f['z_settled']:.2f} before",
             "cycle" + "".join(f"{name:>9}" for name, *_ in COLUMNS), "     " + "".join(f"{unit:>9}" for _, unit, *_ in COLUMNS)]
    for k, cycle in enumerate(f["cycles"], 1):
        lines.append(f"{k:<5}" + "".join(f"{(1e3 if unit.startswith('m') else 1) * cycle[key]:>9.{digits}f}" for _, unit, key, digits in COLUMNS))
    b = f["budget"]
    terms = ", ".join(f"{key[:-2].replace('_', ' ')} {1e3 * value:.3f}" for key, value in b.items() if key.endswith("_J"))
    lines += [f"largest overlap over diameter: rods {f['overlap_rods']:.3f}, walls {f['overlap_walls']:.3f}",
              f"energy from {b['from_s']:.3f} s on, mJ: {terms}",
              f"budget open by {b['defect_percent']:.2f} % of the lid's work; drag {'audited' if b['audited'] else 'estimated from the series'}"]
    if f["rod_share"] is not None:
        lines.append(f"rods take {100 * f['rod_share']:.0f} % of the steps' time")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="directory of a run's results")
    parser.add_argument("--area", type=float, help="of the base, m^2; default: the servo's")
    arguments = parser.parse_args()
    figures = measure(read(arguments.run, arguments.area))
    print(table(figures))
    (arguments.run / "loops.json").write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    needs.in_words(main)
