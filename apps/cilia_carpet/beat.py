"""How a carpet of cilia beats: what plot.py measures in the frames of a run.

Displacements u are those of the tips from where the rods start, in rod lengths L. The phase of a cilium is the argument of the
fundamental of u_x over the last full turn of the field, u_x ~ |a| cos(w t + arg a), at the drive frequency w = 2 pi/T.
"""

from dataclasses import dataclass

import numpy as np
import skein  # where plot.py looks

SHARE_OF_A_STROKE = 0.55  # of a turn; where the slower way takes less, there is no slow stroke
STILL = 0.01              # L; a fundamental below it has no phase to speak of (wave_xy leaves a few cilia unmagnetised)
REPEATS = 0.02            # L; tips closer than this to where they were a turn before repeat it


def period_of(directory):
    """T of the rotating field, s; negative where it turns the other way."""
    loads = skein.open(directory).physics.get("load", [])
    periods = [load["period"] for load in loads if load["kind"] == "magnetic_field" and load["period"] != 0]
    if not periods:
        raise SystemExit(f"{directory}: the scene has no rotating magnetic_field; give --period")
    return periods[0]


@dataclass
class Turn:
    """Tips over the last full turn of the field, both ends of it included, and over the turn before."""
    title: str
    time: np.ndarray           # [frames + 1], s
    displacement: np.ndarray   # u [frames + 1, rods, 3], L
    change: np.ndarray         # |u(t) - u(t - T)| [frames + 1, rods], L; empty where there is no turn before
    origin: np.ndarray         # [rods, 3], m
    magnetisation: np.ndarray  # [rods, 3], unit vectors
    length: float              # L, m
    period: float              # T, s, with the field's sense


def read_turn(directory, period):
    run = skein.open(directory)
    if not len(run.tips):
        raise SystemExit(f"{directory}: no tips_*.h5; the scene needs 'tips' in [output]")
    group = run.rods[0]
    if not run.tips.has(group.name, "magnetisation"):
        raise SystemExit(f"{directory}: group '{group.name}' is not magnetised, so its rods are no cilia")
    title, origin, magnetisation = run.title, group.origin, group.magnetisation
    time, tips = run.tips.time, np.asarray(group.tips)
    if len(time) < 2:
        raise SystemExit(f"{directory}: one frame of tips is not a turn of the field")
    interval = time[1] - time[0]
    frames = round(abs(period) / interval)
    if abs(frames * interval - abs(period)) > 1e-6 * abs(period):
        raise SystemExit(f"{directory}: frames every {interval:g} s do not divide the period of {abs(period):g} s; "
                         "set 'divide' in [time] to the interval of 'tips'")
    if len(time) <= frames:
        raise SystemExit(f"{directory}: {len(time)} frames are less than a turn of {frames}")
    length = np.linalg.norm(tips[0, 0] - origin[0])  # straight at t = 0
    last, before = tips[-frames - 1:], tips[-2 * frames - 1:-frames]
    change = np.linalg.norm(last - before, axis=2) / length if len(before) == len(last) else np.empty((0, len(origin)))
    return Turn(title, time[-frames - 1:], (last - origin) / length, change,
                origin, magnetisation, length, period)


def fundamental(turn):
    """Complex amplitude a of every cilium, u_x ~ Re(a exp(i w t)), L."""
    w = 2 * np.pi / abs(turn.period)
    return 2 * np.mean(turn.displacement[:-1, :, 0] * np.exp(-1j * w * turn.time[:-1, None]), axis=0)


def spacing_of(origin):
    x = np.unique(np.round(origin[:, 0], 9))
    return np.diff(x).min() if len(x) > 1 else np.inf


def neighbours(origin):
    """Pairs of cilia (i, j), j the next one along x."""
    order = np.lexsort((origin[:, 0], origin[:, 1], origin[:, 2]))
    i, j = order[:-1], order[1:]
    step = origin[j] - origin[i]
    next_to = (np.abs(step[:, 0] - spacing_of(origin)) < 1e-6) & (np.abs(step[:, 1:]).max(axis=1) < 1e-6)
    return i[next_to], j[next_to]


def degrees(ratio):
    """Angle of complex numbers within +-180."""
    return np.degrees(np.angle(ratio))


def expected_phase(turn):
    """What the field asks of a cilium magnetised along (sin p, ., cos p): couple ~ sin(w t - p), as unit complex numbers."""
    p = np.arctan2(turn.magnetisation[:, 0], turn.magnetisation[:, 2])
    return np.exp(-1j * np.sign(turn.period) * (p + np.pi / 2))


def repeats_from(turn):
    """Time from which every frame of the turn before comes back within REPEATS a turn later, [rods], s; inf where none does.

    In a run of two turns the first one holds the start from rest, so that the largest change over a turn tells of the start alone.
    """
    late = turn.change >= REPEATS
    last = np.where(late.any(axis=0), len(late) - 1 - np.argmax(late[::-1], axis=0), -1)  # frame that does not repeat
    return np.append(turn.time - abs(turn.period), np.inf)[last + 1]


def spread(values):
    return {"mean": float(np.mean(values)), "min": float(np.min(values)), "max": float(np.max(values))}


def sense(value):
    return "+x" if value > 0 else "-x" if value < 0 else "none"


def measure(turn):
    """The figures of the beat, as plain numbers and words; lags are positive where the neighbour at larger x comes later."""
    u, a = turn.displacement, fundamental(turn)
    beating = np.abs(a) > STILL
    i, j = neighbours(turn.origin)
    both = beating[i] & beating[j]
    lag = degrees(a[i[both]] / a[j[both]])
    wave = float(np.sign(np.mean(lag))) if len(lag) else 0.0

    step = np.diff(u, axis=0)
    forward = np.mean(step[:, :, 0] > 0)  # share of the turn in which tips move to +x
    slower = max(forward, 1 - forward)
    stroke = 0.0 if slower < SHARE_OF_A_STROKE else float(np.sign(forward - 0.5))

    middle = 0.5 * (u[1:] + u[:-1])
    error = (a / expected_phase(turn))[beating]
    error /= np.abs(error)
    figures = {
        "title": turn.title,
        "cilia": len(turn.origin),
        "still": int(np.sum(~beating)),
        "length_m": turn.length,
        "period_s": turn.period,
        "from_s": float(turn.time[0]),
        "to_s": float(turn.time[-1]),
        "lag_to_next_deg": spread(lag) if len(lag) else None,
        "amplitude_half_range_L": spread(0.5 * np.ptp(u[:, :, 0], axis=0)),
        "amplitude_fundamental_L": spread(np.abs(a)),
        "reach_back_L": float(u[:, :, 0].min()),
        "reach_forth_L": float(u[:, :, 0].max()),
        "out_of_plane_L": spread(np.abs(u[:, :, 1]).max(axis=0)),
        "loop_area_L2": spread(np.sum(middle[:, :, 2] * step[:, :, 0], axis=0)),
        "lag_behind_field_deg": float(-degrees(error.mean())),
        "lag_behind_field_rms_deg": float(np.sqrt(np.mean(degrees(error / error.mean()) ** 2))),
        "slow_stroke": sense(stroke),
        "slow_stroke_share": float(slower),
        "wave": sense(wave),
        "plectic": int(stroke * wave),
        "plectic_word": {1: "symplectic", -1: "antiplectic", 0: "neither"}[int(stroke * wave)],
    }
    if len(turn.change):
        worst = turn.change.max(axis=0)
        figures["change_over_a_turn_L"] = float(worst.max())
        figures["periodic_share"] = float(np.mean(worst < REPEATS))
        start = np.sort(repeats_from(turn))
        for key, share in (("repeats_90_percent_from_s", 0.9), ("repeats_all_from_s", 1.0)):
            time = float(start[int(np.ceil(share * len(start))) - 1])
            figures[key] = time if np.isfinite(time) else None  # JSON has no infinity
    return figures


def table(figures):
    def row(name, key, unit, digits):
        f = figures[key]
        return f"{name:<34}{f['mean']:>10.{digits}f}{f['min']:>10.{digits}f}{f['max']:>10.{digits}f}  {unit}"

    f = figures
    lines = [f"{f['title']}: {f['cilia']} cilia, t = {f['from_s']:g} to {f['to_s']:g} s", f"{'':<34}{'mean':>10}{'least':>10}{'most':>10}"]
    if f["lag_to_next_deg"]:
        lines.append(row("lag of the next cilium along x", "lag_to_next_deg", "deg", 2))
    lines += [
        row("half range of u_x", "amplitude_half_range_L", "L", 4),
        row("fundamental of u_x", "amplitude_fundamental_L", "L", 4),
        row("largest |u_y|", "out_of_plane_L", "L", 4),
        row("loop area, closed integral z dx", "loop_area_L2", "L^2", 4),
        f"tips reach from {f['reach_back_L']:.3f} L to {f['reach_forth_L']:.3f} L along x",
        f"behind the field's couple by {f['lag_behind_field_deg']:.2f} deg, rms deviation {f['lag_behind_field_rms_deg']:.2f} deg",
        f"wave towards {f['wave']}, slow stroke {f['slow_stroke']} ({100 * f['slow_stroke_share']:.0f} % of the turn): {f['plectic_word']}",
    ]
    if "periodic_share" in f:
        def since(key):
            return "never" if f[key] is None else f"from {f[key]:g} s"

        lines += [f"tips differ from the turn before by {f['change_over_a_turn_L']:.2e} L at most; "
                  f"{100 * f['periodic_share']:.1f} % of them by less than 2 % L",
                  "what tips do comes back a turn later within 2 % L: "
                  f"90 % of them {since('repeats_90_percent_from_s')}, all {since('repeats_all_from_s')}"]
    return "\n".join(lines)
