"""A run within this process: skein.Simulation("scene.toml"). By ctypes, on the C functions of include/skein/skein.h."""

import ctypes
from functools import cache
from io import StringIO

import numpy as np

from .program import RunFailed, as_file, found, overrides

TEXT, RUN, NUMBER, INTEGER, LONG = ctypes.c_char_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_int64
DOUBLES, LONGS = ctypes.POINTER(NUMBER), ctypes.POINTER(LONG)
FUNCTIONS = {  # name: what it returns, what it takes
    "error": (TEXT,), "rank": (INTEGER,), "ranks": (INTEGER,),
    "open": (RUN, TEXT, TEXT, ctypes.POINTER(TEXT), INTEGER, INTEGER, INTEGER), "close": (None, RUN),
    "plan": (TEXT, RUN), "dt": (NUMBER, RUN), "time": (NUMBER, RUN), "step": (LONG, RUN), "steps": (LONG, RUN),
    "advance": (INTEGER, RUN, LONG), "digest": (TEXT, RUN),
    "observable_names": (TEXT, RUN), "observables": (INTEGER, RUN, DOUBLES, INTEGER), "contacts": (TEXT, RUN),
    "drive": (INTEGER, RUN, TEXT, NUMBER, NUMBER), "set_table": (INTEGER, RUN, TEXT, DOUBLES, DOUBLES, LONG), "restart": (INTEGER, RUN, INTEGER, LONGS, LONG), "table": (LONG, RUN, TEXT, DOUBLES, DOUBLES, LONG),
    "finished": (INTEGER, RUN), "stage": (TEXT, RUN), "next_stage": (INTEGER, RUN), "group_count": (INTEGER, RUN), "group_name": (TEXT, RUN, INTEGER), "group_rods": (LONG, RUN, INTEGER),
    "group_nodes": (INTEGER, RUN, INTEGER), "group_elements": (INTEGER, RUN, INTEGER),
    "numbers": (INTEGER, RUN, INTEGER, LONGS), "read": (INTEGER, RUN, INTEGER, INTEGER, DOUBLES, LONG),
}
QUANTITIES = ("position", "velocity", "directors", "spin")


@cache
def library():
    def none():
        raise FileNotFoundError("libskein.so is not beside this package; build it (cmake --build build --target skein_shared), or set SKEIN to the program")
    # Open MPI's parts look for its names among those of the whole process.
    loaded = ctypes.CDLL(str(found("lib/libskein.so", none)), mode=ctypes.RTLD_GLOBAL)
    for name, (returned, *taken) in FUNCTIONS.items():
        function = getattr(loaded, "skein_" + name)
        function.restype, function.argtypes = returned, taken
    return loaded


def _failed():
    return RunFailed(library().skein_error().decode(), 1)


class Simulation:
    """A scene that is stepped from here; it writes nothing. Several may live side by side; under mpirun all ranks make and call each alike, and
    have their own rods.

        arm = skein.Simulation("arm.toml", **{"rods.arm.shape.elements": 40})
        arm.step(64)
        arm["arm"].position[0, -1]            # the tip, m
        arm.drive("torque", 0.02, until=arm.after(64))

    The arrays of a group are views of memory that the simulation keeps: the same arrays at every step, brought up to date when they are asked for
    after a step. Copy what is to outlast the next step. (The state itself is staggered in time and interleaved by SIMD lanes.)
    """

    def __init__(self, scene, threads=0, lanes=0, **keys):
        self._run = None
        changes = [change.encode() for change in overrides(keys)]
        with as_file(scene) as file:
            self.name = file.stem
            self._run = library().skein_open(str(file).encode(), None, (TEXT * len(changes))(*changes), len(changes), threads, lanes)
        if not self._run:
            raise _failed()
        count = library().skein_group_count(self._run)
        self.groups = {group.name: group for group in (SimulatedGroup(self, number) for number in range(count))}
        self.observable_names = library().skein_observable_names(self._run).decode().split(",")

    def __del__(self):
        self.close()

    def close(self):
        """Gives the run's memory back; arrays of it are not to be used any more."""
        if self._run:
            library().skein_close(self._run)
            self._run = None

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def __repr__(self):
        if not self._run:
            return f"<Simulation '{self.name}': closed>"
        groups = ", ".join(f"'{group.name}' ({len(group.numbers)} of {group.elements} elements)" for group in self.groups.values())
        return f"<Simulation '{self.name}': step {self.steps_done} of {self.steps}, t = {self.time:.6g} s, dt = {self.dt:.6g} s, groups {groups or 'none'}>"

    def __getitem__(self, name):
        """The group of this name."""
        if name not in self.groups:
            raise KeyError(f"no group '{name}'; there are {', '.join(self.groups)}")
        return self.groups[name]

    @property
    def plan(self):
        return library().skein_plan(self._run).decode()

    @property
    def dt(self):
        """s."""
        return library().skein_dt(self._run)

    @property
    def time(self):
        """s."""
        return library().skein_time(self._run)

    def after(self, steps):
        """Time when so many more steps have been made, s, to the last bit."""
        return (self.steps_done + steps) * self.dt

    @property
    def steps_done(self):
        return library().skein_step(self._run)

    @property
    def steps(self):
        """Of the whole scene: none are made beyond."""
        return library().skein_steps(self._run)

    @property
    def finished(self):
        return bool(library().skein_finished(self._run))

    def step(self, count=1):
        """Makes `count` steps, fewer at the scene's end. Raises RunFailed, naming rod, element and quantity, where rods become invalid."""
        if library().skein_advance(self._run, self.steps_done + count):
            raise _failed()
        return self

    @property
    def stage(self):
        """Name of the [[stage]] under way; "" in scenes without."""
        return library().skein_stage(self._run).decode()

    def next_stage(self):
        """Ends the stage now, whatever its own end is."""
        if library().skein_next_stage(self._run):
            raise _failed()
        return self

    @property
    def digest(self):
        """Of the state: that of `skein run` after as many steps."""
        return library().skein_digest(self._run).decode()

    @property
    def observables(self):
        """{heading: value} of what observables.csv would have now."""
        values = np.empty(len(self.observable_names))
        if library().skein_observables(self._run, values.ctypes.data_as(DOUBLES), len(values)) < 0:
            raise _failed()
        return dict(zip(self.observable_names, values.tolist()))

    @property
    def contacts(self):
        """{heading: [contacts]} of all contacts between rods now, as contacts_<step>.csv has them."""
        text = library().skein_contacts(self._run)
        if text is None:
            raise _failed()
        if not text:
            return {}
        head, _, rows = text.decode().partition("\n")
        headings = head.split(",")
        table = np.loadtxt(StringIO(rows), delimiter=",", ndmin=2) if rows else np.zeros((0, len(headings)))
        return dict(zip(headings, table.T))

    def drive(self, table, value, until=None):
        """Lets a [[table]] of the scene, which formulas name as a function of t, go linearly from its last value now to `value` at the time `until`, s (one
        step from now where none is given), and stay there. A scene with the points that the table has in the end repeats the run, bit for bit."""
        until = self.after(1) if until is None else until
        if library().skein_drive(self._run, table.encode(), until, value):
            raise _failed()

    def set_table(self, name, value, at=None):
        """Puts points in the place of a table's own. Without `at` these are 0, 1, 2, ...: in formulas, table(rod) is then the value of each rod."""
        value = np.ascontiguousarray(value, float)
        at = np.arange(len(value), dtype=float) if at is None else np.ascontiguousarray(at, float)
        if at.shape != value.shape or value.ndim != 1:
            raise ValueError(f"a table takes as many places as values, in a row each: here {at.shape} and {value.shape}")
        if library().skein_set_table(self._run, name.encode(), at.ctypes.data_as(DOUBLES), value.ctypes.data_as(DOUBLES), len(value)):
            raise _failed()

    def table(self, name):
        """Points of a [[table]], with those that it was driven through: (at [points], value [points])."""
        count = library().skein_table(self._run, name.encode(), None, None, 0)
        if count < 0:
            raise _failed()
        at, value = np.empty(count), np.empty(count)
        library().skein_table(self._run, name.encode(), at.ctypes.data_as(DOUBLES), value.ctypes.data_as(DOUBLES), count)
        return at, value


class SimulatedGroup:
    """Rods, or bodies, of one name: arrays of those that this rank has, in the order of `numbers` (of all of them on one rank).

    position, velocity    [rods, nodes, 3]          m, m/s
    directors             [rods, elements, 3, 3]    rows d1, d2, d3
    spin                  [rods, elements, 3]       along the directors, rad/s
    """

    def __init__(self, simulation, number):
        self._simulation, self._number, self._arrays, self._restarts = simulation, number, {}, 0
        call, run = library(), simulation._run
        self.name = call.skein_group_name(run, number).decode()
        self.nodes, self.elements = call.skein_group_nodes(run, number), call.skein_group_elements(run, number)

    def __repr__(self):
        return f"<Group '{self.name}' of a simulation: {len(self.numbers)} of {self.elements} elements here>"

    @property
    def numbers(self):
        """Of the rods in their group, rising."""
        count = library().skein_group_rods(self._simulation._run, self._number)
        numbers = np.empty(count, np.int64)
        library().skein_numbers(self._simulation._run, self._number, numbers.ctypes.data_as(LONGS))
        return numbers

    def _array(self, quantity):
        simulation = self._simulation
        step, array = self._arrays.get(quantity, (None, None))
        now = (simulation.steps_done, self._restarts)
        if step != now:
            if array is None:
                inner = (self.nodes, 3) if quantity in ("position", "velocity") else (self.elements, 3, 3) if quantity == "directors" else (self.elements, 3)
                array = np.empty((library().skein_group_rods(simulation._run, self._number), *inner))
            if library().skein_read(simulation._run, self._number, QUANTITIES.index(quantity), array.ctypes.data_as(DOUBLES), array.size):
                raise _failed()
            self._arrays[quantity] = now, array
        view = array.view()
        view.flags.writeable = False
        return view

    def restart(self, rods):
        """Returns these rods to their start while others go on; joined rods together: all of a copy. If rods may touch on several ranks, all ranks call it together, and
        each may name any rods; in other scenes a rank returns those of the named rods that it owns."""
        numbers = np.ascontiguousarray(rods, np.int64)
        if library().skein_restart(self._simulation._run, self._number, numbers.ctypes.data_as(LONGS), len(numbers)):
            raise _failed()
        self._restarts += 1

    position = property(lambda self: self._array("position"))
    velocity = property(lambda self: self._array("velocity"))
    directors = property(lambda self: self._array("directors"))
    spin = property(lambda self: self._array("spin"))
