"""What swimmers of a school do: ways and speeds of their centres of mass, how their bending differs, the work of their muscles.

plot.py draws it. Lengths are in bodies L, times in periods T of the wave, masses in rho L^3, from the file of physics and the frames of a
run: sections and muscles are the scene's own formulas. Swimmers head for negative x; what the wave bends them about is d2.
"""

from dataclasses import dataclass

import numpy as np
import skein  # where plot.py looks
from skein.formula import evaluate as formula

SETTLED = 4.0   # T: what is compared between swimmers is of the time after
WINDOW = 4.5    # T: the last ones, which speeds and powers are told of
NORMAL = 1      # number of d2
SECOND_MOMENT = {"elliptic": np.pi / 4, "rectangular": 4 / 3}  # of a section about d2, over a^3 b                                  theory.md (3), (3a)


@dataclass
class School:
    title: str
    time: np.ndarray       # of frames [frames], T
    places: np.ndarray     # centres of mass [frames, swimmers, 3], L
    curvature: np.ndarray  # about d2 [frames, swimmers, vertices], 1/L
    work: np.ndarray       # of muscles since the start [frames, swimmers], rho L^5/T^2
    bodies: np.ndarray     # nodes in the last frame [swimmers, nodes, 3], L
    spent: tuple           # times [rows], T, what viscosity has taken and what is stored by then, and what is lost at surfaces [rows],
                           # rho L^5/T^2, None if it was not measured; None without a fluid

    @property
    def swimmers(self):
        return self.places.shape[1]


def semi_axes(group, constants, s):
    """How far the sections at arc lengths s reach along d1 and d2, m."""
    section, length = group.physics["section"], group.physics["shape"]["length"]
    if section["kind"] not in SECOND_MOMENT or section["profile"] or section["profile_2"]:
        raise skein.NotResults(f"group '{group.name}': elliptic or rectangular sections by formulas are expected")
    return [np.broadcast_to(formula(section[f"{name}_formula"] or str(section[name]), **constants, s=s, L=length), s.shape) for name in ("radius", "radius_2")]


def at_nodes(values):
    """Of equal elements: means; at the ends on the line through the last two, but half to twice the last."""
    ends = [np.clip(1.5 * last - 0.5 * other, 0.5 * last, 2 * last) for last, other in (values[:2], values[:-3:-1])]
    return np.concatenate([ends[:1], 0.5 * (values[1:] + values[:-1]), ends[1:]])


def mass_shares(a, b):
    """Of nodes in the mass of a rod whose elements have these semi-axes.                                theory.md (4a)

    An element's mass goes with its area, of which the file of frames has the root of a b at nodes alone.
    """
    (a0, a1), (b0, b1) = ((nodes[:-1], nodes[1:]) for nodes in (at_nodes(a), at_nodes(b)))
    before, between, after = a0 * b0, 0.5 * (a0 * b1 + a1 * b0), a1 * b1
    first = a * b * (3 * before + 2 * between + after) / (4 * (before + between + after))
    shares = np.append(first, 0) + np.insert(a * b - first, 0, 0)
    return shares / shares.sum()


def turns(directors):
    """From each element to the next about d2, [..., elements - 1] rad, below a right angle.                   theory.md (6)"""
    r = np.einsum("...ik,...jk->...ij", directors[..., 1:, :, :], directors[..., :-1, :, :])
    axial = np.stack([r[..., i, j] - r[..., j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    sine = 0.5 * np.linalg.norm(axial, axis=-1)
    return 0.5 * axial[..., NORMAL] * np.arcsin(np.minimum(sine, 1)) / np.maximum(sine, 1e-300)


def work_of(couples, turned):
    """Since the start [frames, ...]: couples at vertices half way between frames [frames - 1, ..., vertices] on what vertices turn by from frame to
    frame. Of a sine it is (w h)^2/24 too small, 0.07 % with 50 frames a period.                                   theory.md (36a)"""
    steps = np.sum(couples * np.diff(turned, axis=0), axis=-1)
    return np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])


def read_school(directory):
    run = skein.open(directory)
    muscles = [(group, load) for group in run.rods for load in run.physics.get("load", [])
               if load["kind"] == "muscle_formula" and load["curvature"] and (not load["rods"] or group.name in load["rods"])]
    if len(muscles) != 1 or "period" not in run.constants:
        raise skein.NotResults(f"{directory}: not one group of rods whose muscles change their curvature by a formula, with a constant 'period'")
    (group, load), = muscles
    period, shape, material = run.constants["period"], group.physics["shape"], group.physics["material"]
    length, elements = shape["length"], shape["elements"]
    if shape["length_profile"]:
        raise skein.NotResults(f"{directory}: elements of equal length are expected")
    time = np.asarray(run.time)
    if len(time) < 2 or time[-1] - time[0] < period * (1 + 1e-9):
        raise skein.NotResults(f"{directory}: frames of more than one period are needed")

    a, b = semi_axes(group, run.constants, (np.arange(elements) + 0.5) * length / elements)
    nodes = group.position[:]
    places = np.einsum("frnx,n->frx", nodes, mass_shares(a, b))
    turned = turns(np.asarray(group.directors[:], float))
    half_way = 0.5 * (time[1:] + time[:-1])[:, None, None]
    vertices = np.arange(1, elements) * length / elements
    change = formula(load["curvature"][NORMAL], **run.constants, s=vertices, t=half_way, L=length, rod=np.arange(group.count)[:, None])
    stiffness = material["youngs_modulus"] * SECOND_MOMENT[group.physics["section"]["kind"]] * at_nodes(a)[1:-1] ** 3 * at_nodes(b)[1:-1]
    energy = material["density"] * length**5 / period**2
    return School(run.title, time / period, places / length, turned * elements, work_of(stiffness * change, turned) / energy, nodes[-1] / length,
                  spent(run, group, period, energy))


def spent(run, group, period, unit):
    """Where the muscles' work goes. A body's own inertia is what it has beyond the fluid that fills it.           theory.md (88), (161)"""
    if not (run.directory / "observables.csv").exists() or "fluid_dissipation" not in run.series:
        return None
    within = run.physics["fluid"]["density"] if run.physics["immersion"].get("inner_inertia", True) else 0
    series, own = run.series, 1 - within / group.physics["material"]["density"]
    time, taken = series["time"], series["fluid_dissipation"]
    share = {"fluid_energy": 1, "kinetic_translation": own, "kinetic_rotation": own} | {name: 1 for name in series if name.startswith("elastic")}
    stored = sum(part * series[name] for name, part in share.items())
    def until(power):
        return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    lost = until(series["fluid_power_lost"]) / unit if "fluid_power_lost" in series else None
    return time / period, (until(taken) + stored) / unit, lost


def mean_rate(time, values):
    """Of values [frames, ...] over the period before each frame, from the first whole one on: times, rates."""
    steps = int(round(1 / (time[1] - time[0])))
    return time[steps:], (values[steps:] - values[:-steps]) / (time[steps:] - time[:-steps]).reshape(-1, *[1] * (values.ndim - 1))


def speeds(school):
    """Times; forward and lateral [frames, swimmers] L/T, of velocities that are means over a period."""
    when, velocity = mean_rate(school.time, school.places)
    return when, -velocity[..., 0], np.hypot(velocity[..., 1], velocity[..., 2])


def correlations(curvature):
    """[swimmers, swimmers], of what their curvatures [frames, swimmers, vertices] are beyond the school's mean there and then."""
    beyond = curvature - curvature.mean(axis=1, keepdims=True)
    products = np.einsum("fiv,fjv->ij", beyond, beyond)
    size = np.sqrt(np.diag(products))
    return products / np.maximum(np.outer(size, size), 1e-300)


def separations(places):
    """[swimmers, swimmers]: means over frames of the distances of places [frames, swimmers, 3]."""
    return np.mean([np.linalg.norm(frame[:, None] - frame[None], axis=-1) for frame in places], axis=0)


def pairs_of(matrix):
    """Its entries above the diagonal."""
    return matrix[np.triu_indices(len(matrix), 1)]


def strongest(values, count):
    """Numbers of the `count` largest, of equal ones the first."""
    return np.argsort(-values, kind="stable")[:count]


def ranks(values):
    """From 1 on; equal ones have the mean of theirs."""
    _, number, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - 0.5 * (counts - 1))[number]


def spearman(one, other):
    """Correlation of ranks."""
    return float(np.corrcoef(ranks(one), ranks(other))[0, 1])


@dataclass
class Networks:
    """Of pairs of swimmers, the strongest two per swimmer: by what their bending has in common, and by how near they are."""
    pairs: np.ndarray    # [pairs, 2] swimmers
    similar: np.ndarray  # numbers of pairs
    near: np.ndarray     # the same
    common: np.ndarray   # pairs in both
    rho: float           # Spearman's, of C and -D over all pairs

    @property
    def by_chance(self):
        """As many pairs would two networks drawn by lot have in common."""
        return len(self.near) ** 2 / len(self.pairs)


def networks(school):
    """None for fewer than five swimmers, and before a period has passed after they have settled."""
    since = school.time > SETTLED - 1e-9
    count = 2 * school.swimmers
    if school.swimmers < 5 or school.time[-1] < SETTLED + 1 - 1e-9:
        return None
    similarity, nearness = pairs_of(correlations(school.curvature[since])), -pairs_of(separations(school.places[since]))
    similar, near = strongest(similarity, count), strongest(nearness, count)
    return Networks(np.transpose(np.triu_indices(school.swimmers, 1)), similar, near, np.intersect1d(similar, near), spearman(similarity, nearness))


def told(values):
    """Of swimmers: mean, least, most."""
    return {"mean": float(values.mean()), "least": float(values.min()), "most": float(values.max()), "range": float(np.ptp(values))}


def measure(school):
    """Means over the last periods, or over all of a shorter run."""
    when, forward, lateral = speeds(school)
    first = int(np.argmax(school.time > school.time[-1] - WINDOW - 1e-9))
    over = school.time[-1] - school.time[first]
    late = when > school.time[first] + 1 - 1e-9
    moved, net = school.places[-1] - school.places[0], (school.places[-1] - school.places[first]) / over
    figures = {"title": school.title, "swimmers": school.swimmers, "periods": float(school.time[-1]), "over_last": float(over),
               "forward": told(-net[:, 0]), "lateral": told(lateral[late].mean(axis=0)),
               "forward_last_period": told(forward[-1]), "lateral_last_period": told(lateral[-1]),
               "forward_by_period": [round(float(forward[np.argmin(np.abs(when - t))].mean()), 4) for t in range(1, int(school.time[-1] + 1e-9) + 1)],
               "way_forward": told(-moved[:, 0]), "drift_y": told(moved[:, 1]), "drift_z": told(moved[:, 2]),
               "power": told((school.work[-1] - school.work[first]) / over),
               "finite": bool(all(np.isfinite(values).all() for values in (school.places, school.curvature, school.work)))}
    if school.spent:
        time, *parts = school.spent
        for name, energy in zip(("power_spent", "power_lost"), parts):
            if energy is None: continue
            between = np.interp([school.time[first], school.time[-1]], time, energy)
            figures[name] = float(np.diff(between)[0] / over / school.swimmers)
    found = networks(school)
    if found:
        figures |= {"edges": len(found.near), "overlap": len(found.common), "overlap_by_chance": found.by_chance, "rho": found.rho}
    return figures


def table(figures):
    def words(name, digits=4):
        now = figures[name]
        return f"{now['mean']:.{digits}f}" + (f" ({now['least']:.{digits}f} to {now['most']:.{digits}f})" if figures["swimmers"] > 1 else "")
    over = f"over the last {figures['over_last']:.3g} T"
    lines = [f"{figures['title']}: {figures['swimmers']} swimmer{'s' if figures['swimmers'] > 1 else ''}, {figures['periods']:.4g} T",
             f"  forward    {words('forward')} L/T {over}; last period {words('forward_last_period')}",
             "             by period " + ", ".join(f"{value:.3f}" for value in figures["forward_by_period"]),
             f"  lateral    {words('lateral')} L/T {over}; last period {words('lateral_last_period')}",
             f"  way        forward {words('way_forward')} L; drift in y {words('drift_y')}, in z {words('drift_z')}",
             f"  power      {words('power', 5)} rho L^5/T^3 a swimmer {over}"]
    if "power_spent" in figures:
        lines.append(f"             of which viscosity takes, and fluid and bodies store, {figures['power_spent']:.5f}")
    if "power_lost" in figures:
        lines.append(f"             and {figures['power_lost']:.5f} is lost at surfaces")
    if "rho" in figures:
        lines.append(f"  networks   {figures['overlap']} of {figures['edges']} edges in both, by chance {figures['overlap_by_chance']:.1f}; "
                     f"Spearman's rho of C and -D {figures['rho']:+.3f}")
    return "\n".join([*lines, "  accepted:", *(f"    {'yes' if good else 'NO ':3} {what}" for what, good in acceptance(figures))])


def acceptance(figures):
    """[(words with the figure and what is asked of it, whether it is met)]."""
    forward, lateral = figures["forward"], figures["lateral"]
    spread = forward["range"] / max(abs(forward["mean"]), 1e-300)
    asked = [(f"mean forward speed {forward['mean']:.4f} L/T, within 0.25 to 0.45", 0.25 <= forward["mean"] <= 0.45)]
    if figures["swimmers"] > 1:
        asked += [(f"range of forward speeds {100 * spread:.1f} % of their mean, below 25 %", spread < 0.25),
                  (f"range of lateral speeds {lateral['range']:.4f} L/T, above that of forward speeds, {forward['range']:.4f}", lateral["range"] > forward["range"])]
    if "rho" in figures:
        asked.append((f"|rho| {abs(figures['rho']):.3f}, below 0.5", abs(figures["rho"]) < 0.5))
    return [*asked, ("all numbers are finite", figures["finite"])]
