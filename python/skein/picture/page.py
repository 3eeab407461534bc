"""One page for browsers, with everything in it: it turns, plays and needs no network. Drawn there by three.js (Debian: libjs-three)."""

import base64
import html
import json
import os
import zlib
from pathlib import Path

import numpy as np

from . import shapes
from .draw import _asked, _saved
from .view import View
from ..needs import NotResults

BUDGET = 3.4e6  # bytes of packed frames: with three.js below 5 MB
HOMES = (Path(__file__).parents[1] / "three", Path("/usr/share/javascript/three"), Path("/usr/share/nodejs/three"))
PLACES = 65535
ASPECT = 16 / 9  # of what the camera is framed for; windows that are narrower see more above and below


def page(run, to=None, every=None, first=None, last=None, time=None, rate=12, **choice):
    """Writes OUT/view.html or `to`, and returns the path. `every`: N-th frames; where it is not given, as many frames as fit 5 MB. It opens at the frame
    nearest to `time`, s, and plays from the start where none is given."""
    run, choice = _asked(run, choice)
    scripts = three()
    frames = [k for k in range(len(run.frames)) if (first is None or run.time[k] >= first) and (last is None or run.time[k] <= last)][::every or 1]
    if not frames:
        raise NotResults(f"{run.directory}: no frames to show")
    view = View(run, frames, choice, ASPECT)
    if every is None:
        frames = _fitting(view, frames)
    scene, data = _packed(view, frames)
    shown = 0 if time is None else int(np.argmin(np.abs(run.time[frames] - time)))
    scene |= {"first": shown, "plays": time is None, "rate": rate}
    text = Path(__file__).with_name("page.html").read_text()
    parts = {"TITLE": html.escape(run.title), "THREE": scripts[0], "CONTROLS": scripts[1],
             "SCENE": json.dumps(scene).replace("</", "<\\/"), "DATA": base64.b64encode(data).decode()}
    pieces = text.split("@")
    text = "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))
    to = Path(to or run.directory / "view.html")
    _saved(to, lambda path: path.write_text(text, encoding="utf-8"))
    return to


def three():
    """three.js and its controls for turning, as scripts."""
    given = os.environ.get("SKEIN_THREE")
    for home in (Path(given),) if given else HOMES:
        found = [next((home / name for name in names if (home / name).exists()), None)
                 for names in (("build/three.min.js", "build/three.js"), ("examples/js/controls/OrbitControls.js",))]
        if all(found):
            return [path.read_text(encoding="utf-8").replace("</script", "<\\/script") for path in found]
    raise NotResults("no page: three.js is not here (Debian: libjs-three), nor where SKEIN_THREE says")


def _fitting(view, frames):
    """As many of the frames, evenly apart, as are expected to fit the budget; the last among them."""
    probe = frames[len(frames) // 2: len(frames) // 2 + 2]
    _, alone = _packed(view, probe[:1])
    _, two = _packed(view, probe)
    each = max(len(two) - len(alone), 1) if len(probe) == 2 else len(alone)
    most = max(1, int((BUDGET - len(alone)) / (1.25 * each)))
    apart = max(1, -(-len(frames) // most))
    return frames[::-1][::apart][::-1]


def _packed(view, frames):
    """What the page is told of the scene, and all of its numbers, deflated."""
    run, parts = view.results, []
    low, high = view.low - 0.02 * view.size, view.high + 0.02 * view.size

    def add(array):
        raw = np.ascontiguousarray(array).tobytes()
        parts.append(raw + bytes(-len(raw) % 8))

    palette, groups = _palette(view), []
    for group in view.rods:
        places, shades = [], []
        for frame in frames:
            nodes = np.nan_to_num(group.position[frame].astype(float))
            places.append(np.clip(np.rint((nodes - low) / (high - low) * PLACES), 0, PLACES).astype(np.uint16))
            shades.append(_shades(view, group, frame, palette))
        for values in (places, shades):
            values = np.stack(values)
            add(np.concatenate([values[:1], np.diff(values, axis=0)]))  # modulo 2^16, 2^8
        radius = np.asarray(group.radius, np.float32)
        add(radius)
        groups.append({"rods": group.count, "nodes": group.elements + 1, "closed": group.closed, "radii": radius.size,
                       "low": low.tolist(), "step": ((high - low) / PLACES).tolist()})
    bodies = []
    for group in view.groups:
        if group.is_body:
            bodies += list(_bodies(view, group, frames, add))
    wires = _wires(view, frames, add)
    times = [float(run.time[frame]) for frame in frames]
    unit = {"name": "s", "of": 1} if times[-1] >= 1 else {"name": "ms", "of": 1e-3}
    scale = view.paint.scale
    words = None if scale is None else {"words": scale.words, **{name: f"{scale.factor * getattr(scale, name):.3g}" for name in ("low", "high")}}
    camera = view.camera
    ground = None
    if view.ground_height is not None:
        ground = view.centre.copy()
        ground[view.up_axis] = view.ground_height
    scene = {"frames": len(frames), "times": times, "unit": unit, "groups": groups, "bodies": bodies, "wires": wires, "palette": palette.ravel().tolist(), "scale": words,
             "camera": {"eye": camera.eye.tolist(), "target": camera.target.tolist(), "angle": camera.angle, "aspect": ASPECT}, "up": view.up.tolist(),
             "centre": view.centre.tolist(), "size": view.size, "ground": None if ground is None else ground.tolist()}
    return scene, zlib.compress(b"".join(parts), 9)


def _palette(view):
    """[256, 3] bytes: of the scale, or the colours of single rods and groups."""
    if view.paint.scale is not None:
        return np.rint(255 * np.asarray(view.paint.scale.colours(np.linspace(0, 1, 256)))[:, :3]).astype(np.uint8)
    colours = np.concatenate([view.paint.of(group, view.frames[0])[:, 0] for group in view.rods] or [np.zeros((1, 3))])
    found = np.unique(np.rint(255 * colours).astype(np.uint8), axis=0)[:256]
    return np.concatenate([found, np.zeros((256 - len(found), 3), np.uint8)])


def _shades(view, group, frame, palette):
    """[rods, nodes] places in the palette."""
    colours = np.rint(255 * view.paint.of(group, frame)).astype(np.int32)
    if view.paint.scale is None:
        first = colours[:, 0]
        nearest = np.argmin(np.sum((first[:, None] - palette[None].astype(np.int32))**2, axis=-1), axis=1)
        return np.broadcast_to(nearest[:, None], colours.shape[:2]).astype(np.uint8)
    return np.rint(255 * np.clip(view.paint.share(group, frame), 0, 1)).astype(np.uint8)


def _bodies(view, group, frames, add):
    """One surface for each body, about its centre, and its motion: axes as rows, then the place."""
    meshes = []
    for part in group.parts.get("capsules", []):
        meshes.append(shapes.capsules(part[None, 0:3], part[None, 3:6], part[6:7], np.zeros(3), sides=32))
    for part in group.parts.get("boxes", []):
        meshes.append(shapes.boxes(part[None, 0:3], shapes.axes_of(part[3:7])[None], part[None, 7:10] + part[10], np.zeros(3), times=1))
    mesh = shapes.Mesh.joined(meshes)
    triangles = np.concatenate([mesh.faces[:, [0, 1, 2]], mesh.faces[:, [0, 2, 3]]])
    motion = [np.concatenate([view.axes(group, frame).reshape(group.count, 9), group.position[frame].reshape(group.count, 3)], axis=1) for frame in frames]
    motion = np.stack(motion, axis=1).astype(np.float32)
    for number in range(group.count):
        add(mesh.points.astype(np.float32))
        add(mesh.normals.astype(np.float32))
        add(triangles.astype(np.uint32))
        add(motion[number])
        yield {"vertices": len(mesh.points), "triangles": len(triangles)}


def _wires(view, frames, add):
    """Edges of walls, kept as long as they stay where they are."""
    found = []
    before = None
    for number, frame in enumerate(frames):
        ends = view.wire_ends(float(view.results.time[frame])).astype(np.float32)
        if before is None or ends.shape != before.shape or not np.array_equal(ends, before):
            if found:
                found[-1]["until"] = number
            if len(ends):
                add(ends)
            found.append({"from": number, "until": len(frames), "count": len(ends)})
            before = ends
    return [entry for entry in found if entry["count"]]
