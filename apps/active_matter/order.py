"""How rods in a pit are ordered: what plot.py measures in the series and in the frames of tips of a run.

Directions are those from the start to the end of a rod in the x-y plane; lengths are in rod lengths L, times in periods T of the
muscles. docs/theory.md section 23.
"""

from dataclasses import dataclass

import numpy as np
import skein  # where plot.py looks

WINDOW = 15.0           # degrees: rods this near to a wall's direction lie along it, and rods this near to each other form a cluster
REACH = 0.2             # L: as far apart as centres of rods of a cluster may be
WALL_BANDS = (0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)  # L


@dataclass
class Pit:
    title: str
    time: np.ndarray        # of the series [rows], T
    order: np.ndarray       # S [rows]
    nematic: np.ndarray     # [rows]
    agitation: np.ndarray   # [rows]
    spin_share: np.ndarray  # rotation over translation energy [rows]
    overlap: np.ndarray     # largest, over the diameter [rows]
    frames: np.ndarray      # times of frames of tips, T
    start: np.ndarray       # [frames, rods, 3], L
    end: np.ndarray         # [frames, rods, 3], L
    lower: np.ndarray       # corners of the box in x and y, L
    upper: np.ndarray
    radius: float           # L

    @property
    def mean_order(self):
        return moving_average(self.time, self.order)

    def last_period(self):
        return self.frames > self.frames[-1] - 1 + 1e-9

    def angles(self, frames):
        way = self.end[frames] - self.start[frames]
        return np.arctan2(way[..., 1], way[..., 0])


def moving_average(time, values, width=1.0):
    """Of the last `width` before each time; of the rows since the start before that."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first = np.searchsorted(time, time - width + 1e-9, side="right")
    first = np.minimum(first, np.arange(len(time)))
    return (sums[1:] - sums[first]) / (np.arange(1, len(time) + 1) - first)


def read_pit(directory):
    run = skein.open(directory)
    muscles = [load for load in run.physics.get("load", []) if load["kind"] in ("muscle_wave", "muscle_torques")]
    sides = [wall for wall in run.physics.get("wall", []) if wall["kind"] == "box"]
    if not muscles or not sides or "axis_order" not in run.series:
        raise SystemExit(f"{directory}: no rods with muscles between walls, or no 'order' among the observables")
    if not len(run.tips) or not run.tips.has(run.rods[0].name, "start"):
        raise SystemExit(f"{directory}: no frames of both ends; the scene needs 'tips' and 'both_ends' in [output]")
    group, table = run.rods[0], run.physics["rods"][0]
    length, period, series = table["shape"]["length"], muscles[0]["period"], run.series
    kinetic = np.asarray(series["kinetic_translation"])
    return Pit(run.title, np.asarray(series["time"]) / period, np.asarray(series["axis_order"]), np.asarray(series["nematic_order"]),
               np.asarray(series["agitation"]), np.asarray(series["kinetic_rotation"]) / np.maximum(kinetic, 1e-300), np.asarray(series["max_overlap"]),
               np.asarray(run.tips.time) / period, np.asarray(run.tips.array(group.name, "start")) / length, np.asarray(group.tips) / length,
               np.array(sides[0]["lower"][:2]) / length, np.array(sides[0]["upper"][:2]) / length, table["section"]["radius"] / length)


def clusters(centre, angle):
    """Number of its cluster for every rod, the largest being 0: rods whose axes differ by less than WINDOW and whose centres by less than REACH."""
    count = len(centre)
    root = np.arange(count)

    def find(i):
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i
    order = np.argsort(centre[:, 0])
    x = centre[order, 0]
    for place, i in enumerate(order):
        near = order[place + 1:np.searchsorted(x, x[place] + REACH)]
        turn = np.abs((angle[near] - angle[i] + 0.5 * np.pi) % np.pi - 0.5 * np.pi)
        for j in near[(turn < np.radians(WINDOW)) & (np.linalg.norm(centre[near] - centre[i], axis=1) < REACH)]:
            root[find(i)] = find(j)
    names, number = np.unique([find(i) for i in range(count)], return_inverse=True)
    rank = np.empty(len(names), int)
    rank[np.argsort(-np.bincount(number), kind="stable")] = np.arange(len(names))
    return rank[number]


def measure(pit):
    last = pit.last_period()
    angle = pit.angles(last)
    off_axis = np.degrees(np.abs((angle + np.pi / 4) % (np.pi / 2) - np.pi / 4))
    direction = np.rint(np.degrees(angle) / 90).astype(int) % 4
    windows = [float(((direction == k) & (off_axis <= WINDOW)).mean()) for k in range(4)]
    centre = 0.5 * (pit.start[last] + pit.end[last])
    from_wall = np.minimum(centre[..., :2] - pit.lower, pit.upper - centre[..., :2]).min(axis=-1)
    along = np.abs(np.cos(2 * angle))
    bands = [(low, high, float(along[(from_wall >= low) & (from_wall < high)].mean()))
             for low, high in zip(WALL_BANDS, WALL_BANDS[1:]) if ((from_wall >= low) & (from_wall < high)).any()]
    sizes = np.bincount(clusters(centre[-1], angle[-1]))
    mean, settled = pit.mean_order, pit.time > 5
    out = np.maximum(pit.lower - np.concatenate([pit.start, pit.end])[..., :2], np.concatenate([pit.start, pit.end])[..., :2] - pit.upper)
    return {"title": pit.title, "rods": pit.start.shape[1], "periods": float(pit.time[-1]), "S": float(pit.order[-1]), "mean_S": float(mean[-1]),
            "mean_S_by_period": [round(float(mean[np.searchsorted(pit.time, t) - 1]), 4) for t in range(1, int(pit.time[-1] + 1e-9) + 1)],
            "nematic": float(pit.nematic[-1]), "agitation": float(pit.agitation[pit.time > pit.time[-1] - 1].mean()),
            "spin_over_translation": float(pit.spin_share[pit.time > pit.time[-1] - 1].mean()),
            "windows_0_90_180_270": windows, "windows_together": float(sum(windows)), "order_by_distance_from_wall_L": bands,
            "clusters": sizes[:6].tolist(), "largest_overlap_after_5_T": float(pit.overlap[settled].max()) if settled.any() else None,
            "farthest_end_beyond_a_wall_r": float(out.max() / pit.radius)}


def table(figures):
    words = [figures["title"], f"  S             {figures['S']:.3f}, over the last period {figures['mean_S']:.3f}, after {figures['periods']:g} periods",
             f"  one line      {figures['nematic']:.3f}", f"  agitation     {figures['agitation']:.3g}, energy of spin over that of translation {figures['spin_over_translation']:.3g}",
             "  along walls   " + ", ".join(f"{k * 90}°: {share:.3f}" for k, share in enumerate(figures["windows_0_90_180_270"])) + f"; together {figures['windows_together']:.3f}",
             "  from walls    " + ", ".join(f"{low:g}-{high:g} L: {value:.2f}" for low, high, value in figures["order_by_distance_from_wall_L"]),
             "  clusters      " + ", ".join(map(str, figures["clusters"])) + f" of {figures['rods']} rods"]
    if figures["largest_overlap_after_5_T"] is not None:
        words.append(f"  overlap       {figures['largest_overlap_after_5_T']:.3f} of the diameter at most, after 5 periods")
    return "\n".join(words)
