"""What of a run is shown, and from where: meshes of any frame, and one camera for all."""

from dataclasses import dataclass

import numpy as np

from . import flow, shapes
from .camera import framed
from .colours import BODY, Paint
from ..needs import NotResults

WIRE = np.array([0.62, 0.65, 0.70])
GROUND = np.ones(3)  # as white as the paper: only shadows show
FLAT_ANGLE = 3.0  # degrees: planes of a fluid are seen from afar, so that rods before them stay in their place
OBLIQUE, ABOVE, FRONT = (-0.50, -1.75, 1.05), (-0.15, -0.85, 1.75), (-0.25, -2.0, 0.35)


@dataclass
class Shown:
    """One frame."""
    mesh: shapes.Mesh     # rods, bodies and wires
    casts: shapes.Mesh    # coarse: what throws shadows
    ground: shapes.Mesh   # or None
    time: float           # s
    radius: float         # of the thinnest rod, m
    flat: shapes.Mesh = None  # on which no light falls


@dataclass
class Choice:
    """Options of `skein draw`."""
    colour: object = "auto"    # or colours of the only group's rods, [rods, 3]
    limits: tuple = None       # of the colours, SI
    groups: tuple = ()         # none: all
    walls: bool = True
    ground: object = "auto"    # True, False, or a height, m
    stripe: object = "auto"    # a stripe along d1, which shows twist
    camera: tuple = None       # direction from which to look
    up: tuple = None
    zoom: float = 1.0
    span: float = None         # height of the picture at its middle, m: for several runs to one scale
    detail: float = 1.0
    slices: tuple = ()         # of the fluid: (axis, place in m)
    q: object = None           # of surfaces, 1/s^2, or "auto"
    fluid: str = "auto"        # colour of the fluid
    fluid_limits: tuple = None # of its colours, SI


class View:
    def __init__(self, results, frames, choice, aspect):
        self.results, self.frames, self.choice = results, list(frames), choice
        self.flow = flow.Flow(results, choice) if flow.wanted(choice) else None
        if not results.groups and not self.flow:
            raise NotResults(f"{results.directory}: no rods to draw" + ("; --slice and --q draw the fluid" if results.fluid else ""))
        if not len(results.frames):
            raise NotResults(f"{results.directory}: no trajectory_*.h5, so no rods to draw; set output.trajectory in the scene")
        for name in choice.groups:
            if name not in results.groups:
                raise NotResults(f"{results.directory}: no group '{name}'; there are {', '.join(results.groups)}")
        self.groups = [group for group in results.groups.values() if not choice.groups or group.name in choice.groups]
        self.rods = [group for group in self.groups if not group.is_body]
        by = "group" if self.flow and isinstance(choice.colour, str) and choice.colour == "auto" else choice.colour
        self.paint = Paint(results, by, self.frames[:: max(1, len(self.frames) // 12)], choice.limits)
        self.up_axis, self.up_sign = self._up()
        self.up = self.up_sign * np.eye(3)[self.up_axis] if choice.up is None else np.asarray(choice.up, float) / np.linalg.norm(choice.up)
        slots = sum(group.count * (group.elements + 1) for group in self.rods)
        self.apart = max(1, int(np.ceil(slots / (choice.detail * 600000))))  # nodes of very many rods that are drawn: every so-many-th
        slots //= self.apart
        self.times = int(np.clip(choice.detail * 60000 / max(slots, 1), 1, 8))
        self.sides = int(np.clip(6 + choice.detail * 600000 / max(slots * self.times, 1), 5, 48))
        self.coarse = 2 if slots < 4000 else 1
        times = [float(results.time[frame]) for frame in self.frames]
        times = [times[k] for k in sorted({0, len(times) // 3, 2 * len(times) // 3, len(times) - 1})]
        if self.flow:
            self.flow.measure(times)
            self.flow_corners = self.flow.corners(times)
        self._measure()
        self.ground_height = self._ground()
        corners = np.concatenate([self._corners(), self.wire_ends(float(results.time[self.frames[-1]])).reshape(-1, 3)])
        if self.flow:
            corners = np.concatenate([corners, self.flow_corners])
        flat = {"margin": 0.13, "angle": FLAT_ANGLE, "below": 0.66} if self.flow and self.flow.axis and not choice.camera else {}
        self.camera = framed(corners, choice.camera or self._side(), self.up, aspect, **flat)
        if choice.span:
            far = np.linalg.norm(self.camera.eye - self.camera.target)
            self.camera.angle = 2 * np.degrees(np.arctan(0.5 * choice.span / far))
        self.camera.angle /= choice.zoom

    @property
    def scales(self):
        return [self.paint.scale, self.flow.scale if self.flow else None]

    @property
    def legend(self):
        """[(name, colour)] of groups of rods, where there are several and the colour is theirs."""
        if self.paint.by != "group" or len(self.rods) < 2:
            return []
        return [(group.name, self.paint.of_group(group)) for group in self.rods]

    def marks(self, width, height):
        """Of the fluid's plane, in pixels from the upper left corner."""
        marks = self.flow.marks() if self.flow else []
        if not marks:
            return []
        place = self.camera.project(np.array([point for point, _, _ in marks]))[0]
        pixels = 0.5 * np.array([width, height]) + 0.5 * height * place * [1, -1]
        return [(*pixel, words, where) for pixel, (_, words, where) in zip(pixels, marks)]

    def _up(self):
        if self.choice.up is not None:
            axis = int(np.argmax(np.abs(self.choice.up)))
            return axis, np.sign(self.choice.up[axis])
        for load in self.results.physics.get("load", []):
            if load["kind"] == "gravity":
                g = np.asarray(load["acceleration"], float)
                axis = int(np.argmax(np.abs(g)))
                if np.abs(g[axis]) > 0.99 * np.linalg.norm(g) > 0:
                    return axis, -np.sign(g[axis])
        return 2, 1.0

    def _nodes(self, group, frame):
        return group.position[frame].astype(float).reshape(group.count, -1, 3)

    def _measure(self):
        """Corners of what is shown over the frames, and its thinnest rod."""
        low, high, lowest = [], [], []
        for frame in self.frames[:: max(1, len(self.frames) // 24)]:
            for group in self.groups:
                nodes = self._nodes(group, frame).reshape(-1, 3)
                nodes = nodes[np.isfinite(nodes).all(axis=1)]
                reach = self._reach(group)
                lowest.append(np.min(self.up_sign * nodes[:, self.up_axis]))
                low.append(nodes.min(axis=0) - reach)
                high.append(nodes.max(axis=0) + reach)
        if not low:
            low, high = [self.flow_corners.min(axis=0)], [self.flow_corners.max(axis=0)]
            lowest = [np.min(self.up_sign * self.flow_corners[:, self.up_axis])]
        self.lowest_axis = min(lowest)  # against up_sign, m
        self.low, self.high = np.min(low, axis=0), np.max(high, axis=0)
        self.centre, self.size = 0.5 * (self.low + self.high), 0.5 * np.linalg.norm(self.high - self.low)
        self.radius = min((float(np.min(group.radius)) for group in self.rods), default=0.02 * self.size)

    @staticmethod
    def _reach(group):
        if not group.is_body:
            return float(np.max(group.radius))
        reach = [np.max(np.linalg.norm(parts[:, 0:3], axis=1) + parts[:, 6]) for name, parts in group.parts.items() if name == "capsules" and len(parts)]
        reach += [np.max(np.linalg.norm(parts[:, 0:3], axis=1) + np.linalg.norm(parts[:, 7:10], axis=1) + parts[:, 10]) for name, parts in group.parts.items() if name == "boxes" and len(parts)]
        return max(reach, default=0)

    def _corners(self):
        """Points that the picture shows: nodes of some frames, thickened; of very many a part."""
        points = []
        for frame in self.frames[:: max(1, len(self.frames) // 12)]:
            for group in self.groups:
                nodes = self._nodes(group, frame).reshape(-1, 3)
                nodes = nodes[np.isfinite(nodes).all(axis=1)]
                nodes = nodes[:: max(1, len(nodes) // 20000)]
                reach = self._reach(group)
                points += [nodes + reach * offset for offset in np.concatenate([np.eye(3), -np.eye(3)])]
        return np.concatenate([np.zeros((0, 3)), *points])

    def _side(self):
        """Obliquely from above; flat beds from higher up, flat curtains from the front; a plane of the fluid from before it."""
        if self.flow and self.flow.axis:
            return {"x": (1.0, 0.0, 0.0), "y": (0.0, -1.0, 0.0), "z": (0.0, 0.0, 1.0)}[self.flow.axis]
        extent = (self.high - self.low)[[(self.up_axis + 1) % 3, (self.up_axis + 2) % 3, self.up_axis]]
        if extent[2] < 0.08 * max(extent):
            view = ABOVE
        elif extent[1] < 0.12 * max(extent[0], extent[2]):
            view = FRONT
        elif extent[0] < 0.12 * max(extent[1], extent[2]):
            view = (-FRONT[1], FRONT[0], FRONT[2])
        else:
            view = OBLIQUE
        place = np.zeros(3)
        place[(self.up_axis + 1) % 3], place[(self.up_axis + 2) % 3], place[self.up_axis] = view[0], view[1], view[2] * self.up_sign
        return place

    def _ground(self):
        """Height of the ground: of a wall at rest below, of a plane on which rods lie, of the feet of rods that are held there; None: there is none."""
        if self.choice.ground is False or self.flow and self.choice.ground == "auto":
            return None
        if self.choice.ground is not True and self.choice.ground != "auto":
            return float(self.choice.ground)
        axis, sign = self.up_axis, self.up_sign
        under, slack = self.lowest_axis, 0.02 * self.size + self.radius
        found = []
        walls = self.results.physics.get("wall", [])
        changes = [change.split("=")[0].split(".") for stage in self.results.physics.get("stage", []) for change in stage["change"]]
        changed = {path[1].strip() for path in changes if path[0].strip() == "wall" and path[-1].strip() in ("velocity", "from")}
        for number, wall in enumerate(walls):
            if wall["stages"] or changed & {wall["name"], str(number)}:
                continue  # it is not there, or not at rest, all the time
            if wall["kind"] == "plane" and wall["normal"][axis] * sign > 0.99 * np.linalg.norm(wall["normal"]) and not np.any(wall["velocity"]) and not (wall.get("servo") or {}).get("speed"):
                found.append(sign * wall["point"][axis])
            if wall["kind"] == "box" and "xyz"[axis] + ("-" if sign > 0 else "+") not in wall["open"]:
                found.append(sign * (wall["lower"] if sign > 0 else wall["upper"])[axis])
        found += [sign * load["point"][axis] for load in self.results.physics.get("load", []) if load["kind"] == "anisotropic_plane"]
        found = [height for height in found if height <= under + slack]
        for group in self.rods:
            feet = sign * group.origin[:, axis]
            if group.physics["start"].startswith("clamped") and np.ptp(feet) < 1e-6 * self.size and feet.min() <= under + slack and np.ptp(group.position[self.frames[0]][:, [0, -1], axis]) > 0.1 * self.size:
                found.append(feet.min())
        if found:
            return float(sign * max(found))
        return float(sign * (under - self.radius)) if self.choice.ground is True else None

    def _striped(self, group):
        if not self.results.frames.has(group.name, "normal"):
            return False
        if self.choice.stripe != "auto":
            return bool(self.choice.stripe)
        return (self.results.directory / "observables.csv").exists() and "link" in self.results.series.units

    def _rods(self, group, frame, times, sides, caps):
        drawn = np.unique(np.linspace(0, group.elements, -(-group.elements // self.apart) + 1).astype(int))
        nodes = self._nodes(group, frame)[:, drawn]
        good = np.isfinite(nodes).all(axis=(1, 2))
        paint = self.paint.of(group, frame)[:, drawn]
        radius = np.broadcast_to(group.radius, (group.count, group.elements + 1))[:, drawn]
        normals, flat, striped = None, None, caps and self._striped(group)
        if (group.physics["section"]["kind"] != "circular" or striped) and self.results.frames.has(group.name, "normal"):
            normals = shapes.refined(group.normal[frame].astype(float)[:, drawn][good], times, group.closed)
            flat = group.flatness[None, drawn]  # without directors sections are drawn round
        nodes, radius, paint = nodes[good], radius[good], shapes.linear(paint[good], times)
        if flat is not None:
            radius, flat = radius / np.sqrt(flat), shapes.linear(flat, times)  # the file has that of the square of equal area
        radius = shapes.linear(radius, times)
        if flat is not None and group.physics["section"]["kind"] == "rectangular":
            mesh = shapes.bars(shapes.refined(nodes, times, group.closed), radius, flat * radius, paint, normals, 1 if sides <= 6 else 4, not group.closed)
            return mesh
        mesh = shapes.tubes(shapes.refined(nodes, times, group.closed), radius, paint, sides, normals, flat, 0 if group.closed else caps)
        if striped:
            side = np.arange(len(mesh.points)) % sides
            mesh.colours = np.where(((side <= sides // 12) | (side >= sides - sides // 12))[:, None], 0.35 * mesh.colours, mesh.colours)
        return mesh

    def axes(self, group, frame):
        """Of bodies [bodies, 3, 3], rows; those of the lab where a run keeps no directors."""
        if self.results.frames.has(group.name, "directors"):
            return group.directors[frame].astype(float).reshape(group.count, 3, 3)
        return np.tile(np.eye(3), (group.count, 1, 1))

    def _bodies(self, group, frame):
        place, axes = group.position[frame][:, 0].astype(float), self.axes(group, frame)
        meshes = []
        for part in group.parts.get("capsules", []):
            start, end = (place + np.einsum("bij,i->bj", axes, part[k:k + 3]) for k in (0, 3))
            meshes.append(shapes.capsules(start, end, np.full(group.count, part[6]), BODY))
        for part in group.parts.get("boxes", []):
            meshes.append(shapes.boxes(place + np.einsum("bij,i->bj", axes, part[0:3]), shapes.axes_of(part[3:7]) @ axes, np.tile(part[7:10] + part[10], (group.count, 1)), BODY))
        return meshes

    def wire_ends(self, time):
        """Edges [edges, 2, 3] of walls, but for those of the ground and those far out: planes are drawn as large as the scene needs."""
        walls = self.results.walls(time) if self.choice.walls else None
        if walls is None:
            return np.zeros((0, 2, 3))
        points, polygons, number = walls
        points = np.asarray(points, float)
        if self.ground_height is not None:  # it is drawn already
            level = np.abs(points[:, self.up_axis] - self.ground_height) < self.radius
            kept = [not level[polygon].all() for polygon in polygons]
            polygons, number = [p for p, keep in zip(polygons, kept) if keep], number[kept]
        ends = [shapes.edges(points, [p for p, n in zip(polygons, number) if n == wall]) for wall in np.unique(number)]
        ends = np.concatenate([np.zeros((0, 2, 3)), *(e for e in ends if len(e))])
        return ends[np.all(np.linalg.norm(ends - self.centre, axis=2) < 1.6 * self.size, axis=1)]

    def _wires(self, time):
        ends = self.wire_ends(time)
        return [shapes.wires(ends, 0.0022 * self.size, WIRE)] if len(ends) else []

    def shown(self, frame):
        time = float(self.results.time[frame])
        bodies = [mesh for group in self.groups if group.is_body for mesh in self._bodies(group, frame)]
        fine = [self._rods(group, frame, self.times, self.sides, shapes.CAP_RINGS if self.sides > 6 else 1) for group in self.rods]
        coarse = [self._rods(group, frame, self.coarse, 6 if self.coarse > 1 else 4, 0) for group in self.rods]
        if not self.flow:
            return Shown(shapes.Mesh.joined(fine + bodies + self._wires(time)), shapes.Mesh.joined(coarse + bodies), self._plate(), time, self.radius)
        vortices = self.flow.surfaces(time)
        bodies += self.flow.obstacles(time) + ([vortices] if vortices else [])
        planes = [self.flow.plane(number, time, self.camera.eye) for number in range(len(self.flow.planes))]
        return Shown(shapes.Mesh.joined(fine + bodies + self._wires(time)), shapes.Mesh.joined(coarse + bodies), self._plate(), time, self.radius,
                     shapes.Mesh.joined(planes) if planes else None)

    def _plate(self):
        if self.ground_height is None:
            return None
        margin = 0.35 * self.size
        mesh = shapes.plate(self.low - margin, self.high + margin, self.up_axis, self.ground_height, GROUND)
        mesh.normals *= self.up_sign
        return mesh
