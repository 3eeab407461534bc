"""What a run has written, as NumPy arrays: skein.open("out/carpet_8x8").

Nothing is read before it is asked for. Arrays of frames index across segments; SI units, lab frame; shapes as in docs/files.md.
"""

import json
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

import numpy as np

from . import fluid, polydata
from .formula import evaluate
from .frames import Segments, Snapshot, Times
from .needs import Damaged, NotResults, need_files, reading
from . import notebook
from .own_file import OwnFile

FIELDS = ("velocity", "strain", "curvature", "energy", "contact_force")  # of nodes, in the poly data


def open(directory):
    """Results of a run, one that is going included. Raises NotResults where there are none, and Damaged, one of its kind, with the name of a file that cannot be
    read."""
    return Results(directory)


class Results:
    """All of a run's files.

    title       of the scene
    physics     the scene's numbers, every key of docs/scene.md but times and outputs
    summary     of the end: digest, times, phases; empty during the run
    groups      {name: Group}, in order of the scene, bodies last
    frames      steps and times of the trajectory; tips: those of the tips
    fluid       {name: fluid.Output}, frames of a fluid
    series      columns of observables.csv
    """

    def __init__(self, directory):
        self.directory = Path(directory)
        need_files(self.directory, "physics.json")
        self.frames = Segments(self.directory, "trajectory")
        self.tips = Segments(self.directory, "tips")
        with reading(self.directory / "physics.json"):
            names = [entry["name"] for entry in self.physics.get("rods", []) + self.physics.get("bodies", [])]
        self.groups = {name: Group(self, name) for name in names}

    def __repr__(self):
        times = f" from {self.time[0]:.6g} to {self.time[-1]:.6g} s" if len(self.frames) else ""
        step = self.summary.get("steps", self.checkpoints[-1] if self.checkpoints else 0)
        groups = ", ".join(f"'{name}'" for name in self.groups) or "none"
        return f"<Results {self.directory}: {self.title!r}, {self._ended()} at step {step}, {len(self.frames)} frames{times}, {len(self.tips)} of tips, groups {groups}>"

    def _ended(self):
        return "not ended" if not self.summary else "ended" if self.summary.get("finished", True) else "stopped"

    def _repr_html_(self):
        """A table of the run, with the picture of `skein draw` if there is one."""
        rows = [("directory", self.directory), ("state", self._ended()),
                ("steps", self.summary.get("steps")), ("time [s]", self.summary.get("time_s")), ("wall time [s]", self.summary.get("wall_s")),
                ("frames", len(self.frames)), ("digest", self.summary.get("digest")), *((f"group {name}", group.content()) for name, group in self.groups.items())]
        return notebook.table(self.title, rows) + notebook.picture(self.directory / "picture.png")

    def __getitem__(self, name):
        """The group of this name."""
        if name not in self.groups:
            guess = get_close_matches(name, self.groups, 1)
            raise KeyError(f"no group '{name}'" + (f"; did you mean '{guess[0]}'?" if guess else f"; there are {', '.join(self.groups)}"))
        return self.groups[name]

    @property
    def rods(self):
        """Groups of rods."""
        return [group for group in self.groups.values() if not group.is_body]

    @property
    def bodies(self):
        return [group for group in self.groups.values() if group.is_body]

    @property
    def time(self):
        """Of the frames, s."""
        return self.frames.time

    @property
    def title(self):
        if self.summary.get("title"):
            return self.summary["title"]
        if isinstance(self.frames, Snapshot):
            return self.frames.title or self.directory.name
        for segments in (self.frames, self.tips):
            if segments.paths:
                with reading(segments.paths[0]):
                    title = segments.file(0).attrs["title"]
                return (title.decode() if isinstance(title, bytes) else str(title)) or self.directory.name
        return self.directory.name

    @cached_property
    def physics(self):
        return _json(self.directory / "physics.json")

    @cached_property
    def summary(self):
        path = self.directory / "summary.json"
        return _json(path) if path.exists() else {}

    @cached_property
    def relaxed(self):
        """Whether the rods were relaxed to rest (time.relax). Physics have no times: the summary shows it, or during the run its newest checkpoint."""
        if self.summary or not self.checkpoints:
            return "relaxation" in self.summary
        with OwnFile(self.directory / f"checkpoint_{self.checkpoints[-1]:012d}.h5") as file, reading(file.path):
            return bool(json.loads(file.attrs["settings"])["time"].get("relax"))

    @cached_property
    def constants(self):
        """[constants] of the scene, {name: value}."""
        return {name: entry["value"] for name, entry in self.physics.get("constants", {}).items()}

    @cached_property
    def series(self):
        return Series(self.directory, self.summary)

    @cached_property
    def energies(self):
        """{name: [rows] J} of all columns in joule."""
        return {name: values for name, values in self.series.items() if self.series.units[name] == "J"}

    @cached_property
    def fluid(self):
        return fluid.outputs(self.directory)

    def of_fluid(self, output):
        """The same run with the frames of an output of its fluid, and no rods."""
        found = Results(self.directory)
        found.frames, found.groups = Times(output.step, output.time), {}
        return found

    @cached_property
    def contact_steps(self):
        """Steps at which all contacts were written."""
        return [int(path.stem.split("_")[1]) for path in sorted(self.directory.glob("contacts_*.csv"))]

    def contacts(self, step=None):
        """All contacts at a step of contact_steps, the last where none is given: {heading: [contacts]}."""
        steps = self.contact_steps
        step = steps[-1] if step is None and steps else step
        if step not in steps:
            raise NotResults(f"{self.directory}: no contacts of step {step}; " + (f"there are steps {steps}" if steps else "set output.contacts in the scene"))
        return _table(self.directory / f"contacts_{step:012d}.csv", "rod_1")

    @cached_property
    def checkpoints(self):
        """Steps of the checkpoints that are kept."""
        return [int(path.stem.split("_")[1]) for path in sorted(self.directory.glob("checkpoint_*.h5"))]

    def state(self, step=None):
        """The state in a checkpoint, the newest where none is given: {group: {"position", "velocity" [rods, nodes, 3], "quaternion" [rods, elements, 4],
        "spin" [rods, elements, 3]}}, double precision; positions and directors half a step before velocities."""
        steps = self.checkpoints
        step = steps[-1] if step is None and steps else step
        if step not in steps:
            raise NotResults(f"{self.directory}: no checkpoint of step {step}; there are {steps or 'none'}")
        with OwnFile(self.directory / f"checkpoint_{step:012d}.h5") as file, reading(file.path):
            return {name: _state(self.groups[name], file.read(f"groups/{name}/state")) for name in file.names("groups")}

    def of_checkpoint(self):
        """The same run with its newest checkpoint as the only frame: rods without directors. Raises NotResults where there is none."""
        if not self.checkpoints:
            raise NotResults(f"{self.directory}: neither frames nor a checkpoint")
        found = Results(self.directory)
        found.frames = Snapshot(self.directory / f"checkpoint_{self.checkpoints[-1]:012d}.h5", self.physics)
        found.groups = {name: group for name, group in found.groups.items() if not group.is_body}
        return found

    def walls(self, time=None):
        """[(points [points, 3], polygons as lists of points, number of the wall of each)] nearest to a time, the last where none is given;
        None where none are written."""
        listed = polydata.listed(self.directory / "walls.pvd")
        if not listed:
            return None
        _, path = listed[-1] if time is None else min(listed, key=lambda entry: abs(entry[0] - time))
        return polydata.polygons(polydata.read(path))

    @cached_property
    def _polydata(self):
        return {path.stem.split("_")[1]: path for _, path in polydata.listed(self.directory / "rods.pvd")}

    @property
    def fields(self):
        """Names of what the poly data has at nodes."""
        if not self._polydata:
            return []
        return [name for name in FIELDS if name in polydata.read(next(iter(self._polydata.values())))["PointData"]]

    def has_field(self, frame, name):
        path = self._polydata.get(f"{self.frames.step[frame]:012d}")
        return path is not None and name in polydata.read(path)["PointData"]

    def _field(self, frame, name):
        """[nodes of all rods] of a frame, in order of the scene."""
        step = f"{self.frames.step[frame]:012d}"
        if step not in self._polydata:
            raise NotResults(f"{self.directory}: no poly data of step {int(step)}; set output.paraview = \"vtp\" and output.trajectory in the scene")
        data = polydata.read(self._polydata[step])["PointData"]
        if name not in data:
            raise NotResults(f"{self.directory}: no {name} in {self._polydata[step]}; there are {', '.join(data)}")
        return data[name]


class Group:
    """Rods, or bodies, of one name: `count` of them, with `elements` each.

    position, directors, normal     [frames, ...] across segments, read when indexed
    tips                            [frames of tips, rods, 3]
    radius                          [nodes], or [rods, nodes] of rods with sizes of their own, m
    """

    def __init__(self, results, name):
        self._results, self.name = results, name
        rods = {entry["name"]: entry for entry in results.physics.get("rods", [])}
        bodies = {entry["name"]: entry for entry in results.physics.get("bodies", [])}
        self.is_body = name in bodies
        self.physics = bodies[name] if self.is_body else rods[name]

    def __repr__(self):
        return f"<Group '{self.name}': {self.content()}, {len(self._results.frames)} frames>"

    def content(self):
        """How many rods or bodies it has, in words."""
        try:
            count = f"{self.count} "
        except NotResults:  # no frames yet: how many there are is not known
            count = ""
        return f"{count}rigid bodies" if self.is_body else f"{count}rods of {self.elements} elements"

    def __len__(self):
        return self.count

    def _constant(self, name):
        for segments in (self._results.frames, self._results.tips):
            if segments.has(self.name, name):
                return segments.constant(self.name, name)
        raise NotResults(f"{self._results.directory}: no {name} of group '{self.name}'; the run has written no frames of it")

    @cached_property
    def count(self):
        return len(self._constant("origin"))

    @property
    def elements(self):
        return 1 if self.is_body else self.physics["shape"]["elements"]

    @property
    def closed(self):
        """Whether its rods are rings."""
        return not self.is_body and self.physics["shape"]["closed"]

    @cached_property
    def radius(self):
        return self._constant("radius")

    @property
    def rest_lengths(self):
        """[elements], m, without strain at rest; None of rods whose lengths are their own."""
        shape = self.physics["shape"]
        if self.physics["placement"]["kind"] == "file" or np.any(shape["rest_strain"]):
            return None
        share = np.asarray(shape["length_profile"] or np.ones(self.elements))
        return shape["length"] * share / share.sum()

    @cached_property
    def flatness(self):
        """[nodes]: how far sections reach along d2, over how far along d1. Of elements, and their means at nodes."""
        section, elements = self.physics["section"], self.elements
        if section["kind"] == "circular" or self.is_body:
            return np.ones(elements + 1)
        length = self.physics["shape"]["length"]
        share = np.asarray(self.physics["shape"]["length_profile"] or np.ones(elements), float)
        middle = (np.cumsum(share) - 0.5 * share) / share.sum()

        def scale(radius, profile, otherwise):
            if section.get(f"{radius}_formula"):
                return evaluate(section[f"{radius}_formula"], **self._results.constants, s=middle * length, L=length) / section[radius]
            return np.asarray(section[profile]) if section[profile] else otherwise

        one = scale("radius", "profile", 1 + (section["taper"] - 1) * middle)
        two = scale("radius_2", "profile_2", one)
        ratio = np.broadcast_to(section["radius_2"] * two / (section["radius"] * one), elements)
        return np.concatenate([ratio[:1], 0.5 * (ratio[1:] + ratio[:-1]), ratio[-1:]])

    @cached_property
    def origin(self):
        return self._constant("origin")

    @cached_property
    def magnetisation(self):
        return self._constant("magnetisation")

    @cached_property
    def parts(self):
        """Of bodies: {"capsules" [parts, 7], "boxes" [parts, 11]}, as docs/files.md has them."""
        return {name: self._constant(name) for name in ("capsules", "boxes") if self._results.frames.has(self.name, name)}

    def _array(self, name, hint):
        if not self._results.frames.has(self.name, name):
            raise NotResults(f"{self._results.directory}: no {name} of group '{self.name}'; {hint}")
        return self._results.frames.array(self.name, name)

    @property
    def position(self):
        return self._array("position", "set output.trajectory in the scene")

    def centrelines(self, frame=-1):
        """Nodes of each rod [nodes, 3] at a frame, m, and radii there [nodes], as lists: what skein.Scene.rods_from takes."""
        nodes = self.position[frame]
        return list(nodes), list(np.broadcast_to(self.radius, nodes.shape[:2]))

    def to_pandas(self, frame=-1):
        """A table of a frame with a row per node: rod, node, x, y, z, radius, in m."""
        import pandas
        nodes = self.position[frame]
        rods, each = nodes.shape[:2]
        rod, node = np.divmod(np.arange(rods * each), each)
        x, y, z = nodes.reshape(-1, 3).T
        return pandas.DataFrame({"rod": rod, "node": node, "x": x, "y": y, "z": z, "radius": np.broadcast_to(self.radius, (rods, each)).ravel()})

    @property
    def directors(self):
        return self._array("directors", "set output.directors = true in the scene")

    @property
    def normal(self):
        return self._array("normal", "set output.directors = true in the scene")

    @property
    def tips(self):
        if not self._results.tips.has(self.name, "position"):
            raise NotResults(f"{self._results.directory}: no tips of group '{self.name}'; set output.tips in the scene")
        return self._results.tips.array(self.name, "position")

    def field(self, frame, name):
        """[rods, nodes] (velocity: [rods, nodes, 3]) of a frame, a view of the poly data: velocity m/s, strain, curvature 1/m, energy J/m,
        contact_force N."""
        frame = range(len(self._results.frames))[frame]
        values = self._results._field(frame, name)
        first = 0
        for group in self._results.rods:
            nodes = group.count * (group.elements + 1)
            if group is self:
                return values[first:first + nodes].reshape(group.count, group.elements + 1, *values.shape[1:])
            first += nodes
        raise NotResults(f"{self._results.directory}: poly data has rods, and '{self.name}' are bodies")

    @property
    def state(self):
        """Of the newest checkpoint."""
        return self._results.state()[self.name]


class Series(dict):
    """Columns of observables.csv: {name: [rows]}, their `units`; `headings` are the file's own. series["time"], series["contacts"]; a heading with its
    unit names a column too."""

    def __init__(self, directory, summary):
        self.directory = Path(directory)
        need_files(directory, "observables.csv")
        table = _table(self.directory / "observables.csv", "step")
        self.headings = list(table)
        if not {"step", "time[s]"} <= set(table):
            raise Damaged(f"{self.directory / 'observables.csv'}: its first line names no step and time[s]; it is damaged, or not a file of Skein")
        if not len(table["step"]):
            raise NotResults(f"{directory}: observables.csv has no rows yet")
        # Earlier programs ended a run between two rows: its last state is in the summary alone.
        last = dict(summary.get("observables", {}), **{"step": summary.get("steps", -1), "time[s]": summary.get("time_s", -1)})
        if last["time[s]"] > table["time[s]"][-1] and all(heading in last for heading in table):
            table = {heading: np.append(values, last[heading]) for heading, values in table.items()}
        split = {heading: heading.rstrip("]").split("[") for heading in table}
        self.units = {parts[0]: parts[1] if len(parts) > 1 else "" for parts in split.values()}
        super().__init__((split[heading][0], values) for heading, values in table.items())

    def __missing__(self, name):
        if name in self.headings:
            return self[name.split("[")[0]]
        guess = get_close_matches(name, self, 1)
        raise NotResults(f"{self.directory}: no columns of observables.csv called {name}" + (f"; did you mean {guess[0]}?" if guess else f"; there are {', '.join(self)}"))

    def __repr__(self):
        ends = f" from {self['time'][0]:.6g} to {self['time'][-1]:.6g} s" if len(self.get("time", ())) else ""
        return f"<Series {self.directory}: {len(next(iter(self.values()), ()))} rows{ends}, columns {', '.join(self)}>"

    def to_pandas(self):
        """A DataFrame over time, s; needs pandas."""
        import pandas
        return pandas.DataFrame({name: values for name, values in self.items() if name != "time"}, index=pandas.Index(self["time"], name="time"))

    def to_xarray(self):
        """A Dataset over time with units; needs xarray."""
        import xarray
        return xarray.Dataset({name: ("time", values, {"units": self.units[name]}) for name, values in self.items() if name != "time"},
                              coords={"time": ("time", self["time"], {"units": "s"})})


def _table(path, first):
    """{heading: [rows]} of a file of comma-separated numbers, of which the first heading is known; a last line that is not whole is left out."""
    with reading(path):
        text = Path(path).read_text()
        head, *lines = text[:text.rfind("\n") + 1].splitlines()
        headings = head.split(",")
        if headings[0] != first:
            raise Damaged(f"{path}: its first line does not begin with '{first}'")
        rows = np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.zeros((0, len(headings)))
        if rows.shape[1] != len(headings):
            raise Damaged(f"{path}: its rows have {rows.shape[1]} numbers, and its first line names {len(headings)}")
        return dict(zip(headings, rows.T))


def _json(path):
    """An object; what else a file holds is none of a run's."""
    with reading(path):
        found = json.loads(Path(path).read_text())
        if not isinstance(found, dict):
            raise Damaged(f"{path}: holds no table; it is damaged, or not a file of Skein")
        return found


def _state(group, slots):
    nodes = {"position": slots[..., 0:3], "velocity": slots[..., 3:6]}
    elements = slots if group.is_body or group.closed else slots[:, :-1]
    return nodes | {"quaternion": elements[..., 6:10], "spin": elements[..., 10:13]}
