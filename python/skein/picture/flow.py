"""The fluid in pictures: planes coloured by a quantity, surfaces of equal Q, and obstacles."""

import numpy as np

from . import obstacles, shapes
from .colours import BODY, Scale, bright, named
from ..fluid import QUANTITIES, cut
from ..needs import NotResults

PLANE_POINTS = 600000  # of a plane at detail 1
SURFACE_CELLS = 8e6    # of Q
SHARE_OF_VORTICES = 0.02  # of the volume, within surfaces of the automatic level
# Six tetrahedra of a cube, corners counted by bits x + 2 y + 4 z; all have the diagonal from 0 to 7.
TETRAHEDRA = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])


def wanted(choice):
    return bool(choice.slices) or choice.q is not None


class Flow:
    """What of a run's fluid is shown. `axis`: across the only plane, else ""."""

    def __init__(self, results, choice):
        self.results, self.choice = results, choice
        if not results.fluid:
            raise NotResults(f"{results.directory}: no frames of a fluid; set output.fields, or a [[fluid_output]], in the scene")
        self.axis = choice.slices[0][0] if len(choice.slices) == 1 and choice.q is None else ""
        self.quantity = self._quantity()
        self.planes = [(axis, at, self._of_plane(axis, at, self.quantity)) for axis, at in choice.slices]
        self.vortices = self._of_surface(self.quantity) if choice.q is not None else None
        self.level, self.scale, self.times = None, None, None

    def _quantity(self):
        if self.choice.fluid != "auto":
            if self.choice.fluid not in QUANTITIES:
                raise NotResults(f"no quantity '{self.choice.fluid}' of a fluid; there are {', '.join(QUANTITIES)}")
            return self.choice.fluid
        for quantity in ("speed", f"vorticity_{self.axis or 'z'}", "vorticity"):
            try:
                for axis, at in self.choice.slices:
                    self._of_plane(axis, at, quantity)
                if self.choice.q is not None:
                    self._of_surface(quantity)
                return quantity
            except NotResults:
                pass
        return "speed"

    def _of_plane(self, axis, at, quantity):
        """The output with most frames that has this quantity in this plane."""
        outputs = [output for output in self.results.fluid.values() if output.kind != "blocks" and output.has(quantity)]
        if not outputs:
            raise NotResults(f"{self.results.directory}: no output of the fluid has {quantity} in planes; set output.fields, or fields of a [[fluid_output]], in the scene")
        a, found = "xyz".index(axis), []
        ranges = []
        for output in outputs:
            low, high = (corner[a] for corner in output.reach())
            if output.kind == "slice" and output.across != axis:
                continue
            ranges.append(f"{low:.6g} to {high:.6g} m")
            if low - 1e-9 <= at <= high + 1e-9:
                found.append(output)
        if not found:
            raise NotResults(f"{self.results.directory}: no {quantity} at {axis} = {at:g} m; there is {' and '.join(dict.fromkeys(ranges)) or 'none across ' + axis}")
        return max(found, key=lambda output: len(output.paths))

    def _of_surface(self, quantity):
        outputs = [output for output in self.results.fluid.values() if output.kind != "slice" and output.has("q") and output.has(quantity)]
        if not outputs:
            raise NotResults(f"{self.results.directory}: no output of the fluid has q and {quantity} in space; set output.fields, or a [[fluid_output]] of blocks, in the scene")
        return max(outputs, key=lambda output: len(output.paths))

    @property
    def _used(self):
        return [output for _, _, output in self.planes] + ([self.vortices] if self.vortices else [])

    @property
    def rarest(self):
        """The output with the fewest frames."""
        return min(self._used, key=lambda output: len(output.paths))

    def frames(self, results):
        """Frames of the run at which there is one of the fluid too."""
        return sorted({results.frames.nearest(time) for time in self.rarest.time})

    def measure(self, times):
        """Level of the surfaces and range of the colours over some times, in order."""
        self.times = times
        if self.vortices:
            self.level = self._level(times[-1]) if self.choice.q == "auto" else float(self.choice.q)
        base, unit = QUANTITIES[self.quantity]
        signed = self.quantity not in ("speed", "vorticity")
        low, high = self.choice.fluid_limits or (None, None)
        if high is None:
            shown = [np.ravel(values) for time in times for values in self._values(time)]
            shown = np.concatenate(shown) if shown else np.zeros(1)
            shown = shown[np.isfinite(shown)] if len(shown) else np.zeros(1)
            low, high = np.percentile(shown, (0.5, 99.5)) if len(shown) else (0, 1)
            if self.quantity == "pressure" or not signed:
                low = 0.0 if not signed else low
            else:
                high = max(abs(low), abs(high))
                low = -high
            if high <= low:
                high = low + 1
        words, factor = named(base, unit, max(abs(low), abs(high)))
        self.scale = Scale(words, low, high, bright("RdBu_r" if signed and self.quantity != "pressure" else "viridis"), factor)

    def _values(self, time):
        yield from (self.layer(number, time).values for number in range(len(self.planes)))
        if self.vortices:
            yield self._surface(time)[3]

    def layer(self, number, time):
        """Field of one layer: of a plane, at the frame nearest to a time."""
        axis, at, output = self.planes[number]
        field = output.read(output.nearest(time), self.quantity)
        return field if output.kind == "slice" else cut(field, axis, at)

    def _level(self, time):
        q = self.vortices.read(self.vortices.nearest(time), "q").values
        above = np.sort(q[q > 0])
        if not len(above):
            raise NotResults(f"{self.results.directory}: no Q above 0 at {time:g} s, so no vortices to draw")
        most = int(SHARE_OF_VORTICES * self._volume() / self.vortices.spacing**3)
        level = float(above[max(len(above) - most, 0)] if most < len(above) else above[len(above) // 2])
        return float(f"{level:.2g}")

    def _volume(self):
        """Of the fluid; if the scene has margins, which give no cells, of the box round the output."""
        fluid = self.results.physics["fluid"]
        if fluid["cells"]:
            return np.prod(fluid["cells"]) * fluid["spacing"] ** 3
        low, high = self.vortices.corners(-1)
        return np.prod(high - low)

    def _reach(self, output):
        """Lower and upper corner of an output over the times that are shown: its box may move."""
        return output.reach(*(output.nearest(time) for time in (self.times[0], self.times[-1])))

    def _surface(self, time):
        """Points, normals, triangles, values at points."""
        frame = self.vortices.nearest(time)
        q, coloured = self.vortices.read(frame, "q"), self.vortices.read(frame, self.quantity)
        stride = int(np.ceil((q.values.size / max(SURFACE_CELLS * min(self.choice.detail, 1), 1e5)) ** (1 / 3)))
        q.values, coloured.values = (field.values[::stride, ::stride, ::stride] for field in (q, coloured))
        points, normals, triangles, values = level_surface(q.values, self.level, coloured.values)
        return q.lower + q.spacing * (0.5 + stride * points), normals, triangles, values

    def surfaces(self, time):
        """Of equal Q, lit; None: none are asked for."""
        if not self.vortices:
            return None
        points, normals, triangles, values = self._surface(time)
        return shapes.Mesh(points, normals, triangles[:, [0, 1, 2, 2]], self.scale.paint(values))

    def plane(self, number, time, eye):
        """A plane as quadrilaterals whose colours are those of the bar: no light falls on them."""
        axis, at, _ = self.planes[number]
        a = "xyz".index(axis)
        u, v = [i for i in range(3) if i != a]
        field = self.layer(number, time)
        values = np.squeeze(field.values, 2 - a)  # [v, u]
        stride = int(np.ceil(np.sqrt(values.size / (PLANE_POINTS * min(self.choice.detail, 1)))))
        values = values[::stride, ::stride]
        low, high = field.lower, field.upper
        sides = [np.concatenate([[low[i]], low[i] + field.spacing * (0.5 + stride * np.arange(count)), [high[i]]]) for i, count in ((u, values.shape[1]), (v, values.shape[0]))]
        values = np.pad(values, 1, mode="edge")
        points = np.empty((*values.shape, 3))
        points[..., u], points[..., v] = np.meshgrid(*sides)
        points[..., a] = at
        number = np.arange(values.size).reshape(values.shape)
        faces = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
        normal = np.zeros(3)
        normal[a] = 1.0 if eye[a] > at else -1.0
        return shapes.Mesh(points.reshape(-1, 3), np.tile(normal, (values.size, 1)), faces, self.scale.paint(np.nan_to_num(values)).reshape(-1, 3))

    def corners(self, times):
        """Points that a picture shows."""
        found = []
        for number, (axis, at, output) in enumerate(self.planes):
            low, high = self._reach(output)
            a = "xyz".index(axis)
            low[a] = high[a] = at
            found.append(np.array(np.meshgrid(*zip(low, high))).reshape(3, -1).T)
        if self.vortices:
            found += [self._surface(time)[0][::7] for time in times]
        points = np.concatenate(found)
        if not len(points):
            points = np.stack(self._reach(self.vortices))
        return points

    def marks(self):
        """Places along the edges of the only plane, and what is written there: [(point, words, "below" or "left")]."""
        if not self.axis:
            return []
        from matplotlib.ticker import MaxNLocator
        axis, at, output = self.planes[0]
        low, high = self._reach(output)
        a = "xyz".index(axis)
        low[a] = at
        found = []
        for i, where in zip([i for i in range(3) if i != a], ("below", "left")):
            ticks = MaxNLocator(6 if where == "below" else 4, steps=[1, 2, 5, 10]).tick_values(low[i], high[i])
            for tick in ticks[(ticks >= low[i] - 1e-9) & (ticks <= high[i] + 1e-9)]:
                place = low.copy()
                place[i] = tick
                found.append((place, f"{tick:.6g}", where))
            middle = low.copy()
            middle[i] = 0.5 * (low[i] + high[i])
            found.append((middle, f"{'xyz'[i]} [m]", f"{where} all"))
        return found

    def obstacles(self, time):
        meshes = []
        for obstacle in self.results.physics.get("obstacle", []):
            place = obstacles.place(obstacle, time)
            if obstacle["kind"] == "sphere":
                meshes.append(shapes.capsules(place[None], place[None], np.array([obstacle["radius"]]), BODY))
            elif obstacle["kind"] != "cylinder":
                meshes.append(obstacles.surface(obstacle, time, self.results))
            else:
                low, high = zip(*(self._reach(output) for output in self._used))
                bottom, top = np.min(low, axis=0)[2], np.max(high, axis=0)[2]
                top = next((at for axis, at, _ in self.planes if axis == "z"), top)  # what stands on a plane would hide it
                ends = np.stack([[*place[:2], bottom], [*place[:2], top + 1e-3 * obstacle["radius"]]])
                second = obstacle["second_radius"] or obstacle["radius"]
                column = shapes.columns(ends, obstacle["radius"], second, BODY)
                rows, foot = obstacles.axes(obstacle, time), ends[0]
                if rows[0][0] != 1:  # an elliptic one that is turned
                    column = shapes.Mesh(foot + (column.points - foot) @ rows, column.normals @ rows, column.faces, column.colours)
                meshes.append(column)
        return meshes


def level_surface(values, level, others):
    """Where values [z, y, x] have a level, by tetrahedra: points [points, 3] (x, y, z in cells), unit normals towards smaller values, triangles
    [triangles, 3], and `others` at the points. Second order; closed but where it leaves the array."""
    values = np.nan_to_num(np.asarray(values, np.float64))
    nothing = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros(0)
    if min(values.shape) < 2:
        return nothing
    above = values > level
    count = sum(above[z:above.shape[0] - 1 + z, y:above.shape[1] - 1 + y, x:above.shape[2] - 1 + x].astype(np.int8) for z in (0, 1) for y in (0, 1) for x in (0, 1))
    cells = np.flatnonzero((count > 0) & (count < 8))
    if not len(cells):
        return nothing
    shape = values.shape
    z, y, x = np.unravel_index(cells, count.shape)
    corner = [np.ravel_multi_index((z + (k >> 2 & 1), y + (k >> 1 & 1), x + (k & 1)), shape) for k in range(8)]
    corner = np.stack(corner, axis=1)[:, TETRAHEDRA].reshape(-1, 4)
    inside = above.ravel()[corner]
    inner = inside.sum(axis=1)
    order = np.argsort(~inside, axis=1, kind="stable")  # corners above the level first
    corner = np.take_along_axis(corner, order, axis=1)
    edges = []  # of triangles: [triangles, 3 points, 2 corners]
    for above_count, triangles in ((1, [[(0, 1), (0, 2), (0, 3)]]), (3, [[(0, 3), (1, 3), (2, 3)]]), (2, [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]])):
        of = corner[inner == above_count]
        edges += [of[:, np.array(triangle)] for triangle in triangles]
    edges = np.concatenate(edges).reshape(-1, 2)
    size = values.size
    key, back = np.unique(edges.min(axis=1) * size + edges.max(axis=1), return_inverse=True)
    a, b = key // size, key % size
    flat = values.ravel()
    share = ((level - flat[a]) / (flat[b] - flat[a]))[:, None]
    place = lambda n: np.stack(np.unravel_index(n, shape)[::-1], axis=1).astype(float)  # noqa: E731
    points = (1 - share) * place(a) + share * place(b)
    corners_slope = [np.gradient(values, axis=2 - i).ravel() for i in range(3)]
    normals = -shapes.unit(np.stack([(1 - share[:, 0]) * slope[a] + share[:, 0] * slope[b] for slope in corners_slope], axis=1))
    other = np.nan_to_num(np.asarray(others, float)).ravel()
    triangles = back.reshape(-1, 3)
    face = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])
    wrong = np.sum(face * normals[triangles].mean(axis=1), axis=1) < 0
    triangles[wrong] = triangles[wrong][:, ::-1]
    return points, normals, triangles, (1 - share[:, 0]) * other[a] + share[:, 0] * other[b]
