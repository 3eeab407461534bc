"""How magnetic millipedes walk: what plot.py measures in the frames of a run.

A robot is a copy of the assembly; its place is its centre of mass. Lengths are in L_b, the length of the rods along its body. Cycles
are those of the field, from its onset on.
"""

from dataclasses import dataclass

import numpy as np
import skein  # where plot.py looks


@dataclass
class Walk:
    title: str
    time: np.ndarray    # [frames], s
    centre: np.ndarray  # of every robot [frames, robots, 3], m
    length: float       # L_b, m
    width: float        # m
    radius: float       # m
    onset: float        # of the field, s
    period: float       # of the field, s

    def cycle(self, time):
        return (time - self.onset) / self.period

    def frame_of(self, cycle):
        """The frame nearest to the end of a cycle."""
        return int(np.abs(self.cycle(self.time) - cycle).argmin())

    @property
    def cycles(self):
        """Whole cycles that the run has done."""
        return int(np.floor(self.cycle(self.time[-1]) + 1e-9))


def read_walk(directory):
    run = skein.open(directory)
    fields = [load for load in run.physics.get("load", []) if load["kind"] == "magnetic_field" and load["period"] != 0]
    tables = {table["name"]: table for table in run.physics.get("rods", [])}
    if not fields or "along" not in tables:
        raise SystemExit(f"{directory}: no robots with rods 'along' in a rotating magnetic field")
    robots = len(run.rods[1]) // tables["along"]["placement"]["counts"][1]
    centre, mass = 0.0, 0.0
    for group in run.rods:
        table = tables[group.name]
        per_node = table["material"]["density"] * np.pi * table["section"]["radius"] ** 2 * table["shape"]["length"] / group.elements
        weight = np.full(group.elements + 1, per_node)
        weight[[0, -1]] *= 0.5
        rods = len(group) // robots
        for_one = [np.einsum("rnk,n->k", x.reshape(robots * rods, -1, 3)[c * rods:(c + 1) * rods], weight)
                   for x in group.position for c in range(robots)]
        centre = centre + np.asarray(for_one, float).reshape(-1, robots, 3)
        mass += weight.sum() * rods
    along, across = tables["along"], tables["across"]
    return Walk(run.title, np.asarray(run.time), centre / mass, along["shape"]["length"], across["shape"]["length"],
                along["section"]["radius"], fields[0]["onset"], abs(fields[0]["period"]))


def measure(walk):
    """Figures of a walk; lengths in L_b, heights in m."""
    first, last = walk.frame_of(0), walk.frame_of(walk.cycles)
    way = (walk.centre[last] - walk.centre[first]) / walk.length
    mean = way.mean(axis=0)
    forward = float(mean[0])
    figures = {"title": walk.title, "robots": walk.centre.shape[1], "cycles": walk.cycles, "forward_L": forward,
               "sideways_L": float(mean[1]), "sideways_over_forward": float(abs(mean[1] / forward)) if forward else None,
               "height_m": [float(walk.centre[first:, :, 2].min()), float(walk.centre[first:, :, 2].max())]}
    if walk.cycles >= 3:
        one, three = walk.frame_of(1), walk.frame_of(3)
        figures["forward_between_cycles_1_and_3_L"] = float((walk.centre[three] - walk.centre[one])[:, 0].mean() / walk.length)
    figures["formation_rms_L"] = [round(float(x), 6) for x in formation(walk)[[walk.frame_of(c) for c in range(walk.cycles + 1)]]]
    return figures


def formation(walk):
    """Rms distance of the robots from where the mean displacement has taken them, by frame, L_b."""
    moved = walk.centre - walk.centre[0]
    off = (moved - moved.mean(axis=1, keepdims=True))[:, :, :2] / walk.length
    return np.sqrt((off ** 2).sum(axis=2).mean(axis=1))


def table(figures):
    lines = [figures["title"],
             f"  forward       {figures['forward_L']:.3f} L_b in {figures['cycles']} cycles"
             + (f", {figures['forward_L'] / figures['cycles']:.3f} a cycle" if figures["cycles"] else "")]
    if "forward_between_cycles_1_and_3_L" in figures:
        lines.append(f"  cycles 1 to 3 {figures['forward_between_cycles_1_and_3_L']:.3f} L_b")
    lines.append(f"  sideways      {figures['sideways_L']:.3f} L_b")
    lines.append("  height        {:.3f} to {:.3f} m".format(*figures["height_m"]))
    if figures["robots"] > 1:
        lines.append("  formation     rms {:.4f} L_b after the last cycle".format(figures["formation_rms_L"][-1]))
    return "\n".join(lines)
