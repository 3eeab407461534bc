"""Runs of the skein driver for tests: a small scene, mpirun, results."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

SKEIN, MPIRUN = sys.argv[1:3]
del sys.argv[1:3]

# For a command that all ranks are to end by themselves with another exit code than 0: mpirun then sleeps for 2 s before it kills those that
# are left, and does so even where none is.
REFUSED = os.environ | {"OMPI_MCA_odls_base_sigkill_timeout": "0"}

SCENE = """
title = "Driver test"
[time]
duration = 14.4
[[rods]]
name = "cilia"
start = "clamped"
[rods.material]
density = 2390.0
youngs_modulus = 1.85e5
shear_modulus = 6.16e4
[rods.section]
radius = 0.15
[rods.shape]
length = 1.5
elements = 10
[rods.placement]
kind = "lattice"
counts = [5, 5]
spacing = [1.5, 1.5]
[rods.magnetisation]
pattern = "wave_x"
strength = 18999.0
wavelength_x = 6.0
[[rods]]
name = "leaning"
start = "pinned"
end = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
kind = "elliptic"
radius = 0.05
radius_2 = 0.03
taper = 0.6
[rods.shape]
length = 1.0
elements = 7
rest_curvature = [0.3, 0.1, 0.2]
[rods.placement]
kind = "line"
counts = [3]
spacing = [0.4]
origin = [0.0, 9.0, 0.0]
[[load]]
kind = "magnetic_field"
constant = [0.0, 8e-4, 0.0]
rotating = 0.08
period = 7.2
ramp = 0.01
[[load]]
kind = "gravity"
rods = ["leaning"]
[[damping]]
kind = "legacy"
rate = 0.5
rods = ["cilia"]
[output]
trajectory = 1.8
tips = 0.36
series = 0.72
checkpoint = 3.6
observables = ["knots", "curvature", "angular_momentum"]
"""


STICKS = """
[[rods]]
name = "sticks"
[rods.material]
density = 1000.0
youngs_modulus = 1e7
law = "linear"
[rods.section]
radius = 0.005
[rods.shape]
length = 0.1
elements = 6
"""  # to be packed

LAW = 'law = "hertz"\nstiffness = 1e5\ndamping = 10.0\n'


def bed_under_a_lid(count, height, servo=""):
    """Sticks that are packed in a box of 0.15 m x 0.15 m up to a height and fall; a lid that begins 0.01 m above it presses them. `servo`: more of its keys."""
    return f"""
[time]
duration = 0.2
{STICKS}
[rods.placement]
kind = "packing"
count = {count}
seed = 3
region = "box"
lower = [0.0, 0.0, 0.0]
upper = [0.15, 0.15, {height}]
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 2.0
[contact]
{LAW}
[[wall]]
name = "box"
kind = "box"
lower = [0.0, 0.0, 0.0]
upper = [0.15, 0.15, 0.5]
open = ["z+"]
{LAW}
[[wall]]
name = "lid"
kind = "plane"
point = [0.0, 0.0, {height + 0.01:g}]
normal = [0.0, 0.0, -1.0]
{LAW}
[wall.servo]
speed = 0.4
watch = "box z-"
area = 0.0225
turn_back_above = 200.0
turn_forth_below = 20.0
average = 1e-3
{servo}"""


# A box between walls and a ball that swings in it; a scene of both says what the velocity is at the start, and how long it goes on.
FLUID_IN_A_BOX = """
[constants]
k = { value = 3.141592653589793, unit = "1/m" }
U = { value = 1.0, unit = "m/s" }
[fluid]
cells = [24, 20, 16]
spacing = 0.1
lower = [0.5, -1.0, 0.0]
density = 2.0
viscosity = 0.01
along_y = "no_slip"
along_z = "free_slip"
"""
# A periodic box of 3.2 m x 2.4 m x 2 m: that of rods_in_a_fluid().
FLUID_OF_RODS = """
[fluid]
cells = [32, 24, 20]
spacing = 0.1
density = 2.0
viscosity = 0.02
courant = 0.4
expected_speed = 2.0
"""


def rods_in_a_fluid(thick, threads, spin):
    """A thick rod that crosses the faces of a box of 3.2 m x 2.4 m x 2 m on its way, and two thin ones; densities and Young's moduli."""
    return f"""
[[rods]]
name = "thick"
[rods.material]
density = {thick[0]}
youngs_modulus = {thick[1]}
[rods.section]
kind = "elliptic"
radius = 0.3
radius_2 = 0.2
[rods.shape]
length = 1.2
elements = 6
velocity = [1.0, 0.2, 0.0]
angular_velocity = {spin}
[rods.placement]
origin = [0.2, 1.2, 0.4]
tangent = [0.6, 0.0, 0.8]
[[rods]]
name = "threads"
[rods.material]
density = {threads[0]}
youngs_modulus = {threads[1]}
[rods.section]
radius = 0.04
[rods.shape]
length = 1.0
elements = 6
velocity = [0.0, 0.0, -1.0]
[rods.placement]
kind = "list"
origins = [[2.5, 0.4, 1.0], [2.5, 1.8, 1.0]]
tangent = [0.0, 1.0, 0.0]
"""


def disc_on_a_spring(cells, density, spring, duration):
    """A disc of 1 m across in a box of 6 m, drawn by a spring of a modulus per length [N/m^2] to the middle; one layer of elements as thick as two cells or four."""
    depth = 0.25
    return f"""
title = "disc on a spring"
[time]
duration = {duration}
[fluid]
cells = [{cells}, {cells}, {round(cells * depth / 6)}]
spacing = {6 / cells}
lower = [-3.0, -3.0, 0.0]
density = 1.0
viscosity = 0.01
courant = 0.5
expected_speed = 0.65
largest_slip = 0
[constants]
k = {{ value = {spring!r}, unit = "N/m^2" }}
[[rods]]
name = "disc"
[rods.material]
density = {density}
youngs_modulus = 1000.0
[rods.section]
radius = 0.5
[rods.shape]
length = {depth}
elements = 2
[rods.placement]
origin = [0.1, 0.0, 0.0]
[[load]]
kind = "formula"
force = ["-k*x", "-k*y", "0"]
[output]
series = 0.1
"""


BALL_IN_IT = """
[[obstacle]]
name = "ball"
centre = [1.5, 0.1, 0.8]
radius = 0.25
amplitude = [0.0, 0.0, 0.2]
frequency = 1.0
"""


def table(name, keys):
    """Of a scene: `name` with its brackets."""
    return "\n".join([name, *(f"{key} = {json.dumps(value)}" for key, value in keys.items())]) + "\n"


def group(name, youngs_modulus, radius, length, elements, tables=None, **keys):
    """[[rods]] of a scene, of density 1000. `keys` of the group itself; `tables`: keys of those below it, by their names."""
    parts = {"material": {"density": 1000.0, "youngs_modulus": youngs_modulus}, "section": {"radius": radius},
             "shape": {"length": length, "elements": elements}}
    for part, more in (tables or {}).items():
        parts.setdefault(part, {}).update(more)
    return table("[[rods]]", {"name": name} | keys) + "".join(table(f"[rods.{part}]", more) for part, more in parts.items())


def mixed(h):
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
    h = (h ^ (h >> 27)) * 0x94D049BB133111EB % 2**64
    return h ^ (h >> 31)


def digest_of(gid, numbers):
    """hash_numbers of src/tiles/rods.cpp."""
    prime = 0x9E3779B97F4A7C15
    h = mixed((gid + prime) % 2**64)
    for word in numpy.ascontiguousarray(numbers, dtype=numpy.float64).view(numpy.uint64).ravel():
        h = (h ^ int(word)) * prime % 2**64
        h = ((h << 27) | (h >> 37)) % 2**64
    return mixed(h)


def text_digest(text):
    """text_digest of src/io/files.cpp."""
    digest = 0xCBF29CE484222325
    for byte in text.encode():
        digest = (digest ^ byte) * 0x100000001B3 % 2**64
    return digest


SUMMED_PER_RANK = ("contact_energyJ", "contact_friction_workJ", "contact_viscous_workJ")
SEARCH = ("candidates", "rebuilds", "skinm")  # which a restart begins anew


def launch(*words, ranks=1, refused=False, timeout=200):
    """A rank by itself without mpirun, which would take longer than most of these runs."""
    command, environment = [SKEIN, *map(str, words)], None
    if ranks > 1:
        command, environment = [MPIRUN, "-n", str(ranks), *command], REFUSED if refused else None
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=environment)


class DriverTest(unittest.TestCase):
    def setUp(self):
        self._directory = tempfile.TemporaryDirectory()
        self.directory = pathlib.Path(self._directory.name)
        self.scene = self.directory / "scene.toml"
        self.scene.write_text(SCENE)
        self.wider = set()

    def tearDown(self):
        self._directory.cleanup()
        if self.wider: self.skipTest(f"runs for {', '.join(sorted(self.wider))} lanes had more, as their kernels are not built: they were compared with themselves")

    def command(self, out, *arguments, ranks=1, threads=1):
        return [MPIRUN, "-n", str(ranks), SKEIN, "run", str(self.scene), "--out", str(self.directory / out),
                "--threads", str(threads), *arguments]

    def run_skein(self, out, *arguments, expect=0, ranks=1, **layout):
        return self.skein_says(*self.command(out, *arguments, **layout)[4:], ranks=ranks, expect=expect)

    def solve_scene(self, command, out, *arguments, text, threads=1, **layout):
        """What a command that solves a scene says of this text."""
        self.scene.write_text(text)
        return self.skein_says(command, self.scene, "--out", self.directory / out, "--threads", threads, *arguments, **layout)

    def skein_says(self, *words, ranks=1, expect=0):
        done = launch(*words, ranks=ranks, refused=expect != 0)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        self.note_lanes([str(word) for word in words])
        return done

    def note_lanes(self, words):
        """Notes runs that have had more lanes than they were to have. A test with such runs is skipped at its end, after all of its comparisons."""
        if "--lanes" not in words or "--out" not in words: return
        asked, summary = (words[words.index(word) + 1] for word in ("--lanes", "--out"))
        summary = pathlib.Path(summary) / "summary.json"
        if summary.exists() and json.loads(summary.read_text()).get("lanes", 0) > int(asked): self.wider.add(asked)

    def plan_text(self, *options):
        done = subprocess.run([SKEIN, "plan", str(self.scene), "-v", *options], capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def plan(self, *options):
        return json.loads(self.plan_text("--json", *options))

    def summary(self, out):
        return json.loads((self.directory / out / "summary.json").read_text())

    def digest(self, out):
        return self.summary(out)["digest"]

    def frames(self, out, kind):
        """All frames of an output, whichever segments it was written in: {dataset: array}."""
        found = {}

        def collect(name, item):
            if isinstance(item, h5py.Dataset) and "/frames/" not in name:
                found.setdefault(name, []).append(item[:])

        for segment in sorted((self.directory / out).glob(f"{kind}_*.h5")):
            with h5py.File(segment) as file:
                file.visititems(collect)
        growing = ("step", "time", "digest", "/position", "/directors", "/normal")
        return {name: numpy.concatenate(parts) if name.endswith(growing) else parts[0] for name, parts in found.items()}

    def assert_same_frames(self, out, whole, group):
        """Bit for bit; `group` has to be among them."""
        for kind in ("trajectory", "tips"):
            mine, theirs = self.frames(out, kind), self.frames(whole, kind)
            self.assertEqual(mine.keys(), theirs.keys())
            self.assertIn(f"groups/{group}/position", mine)
            for name in mine:
                self.assertTrue(numpy.array_equal(mine[name], theirs[name]), f"{kind} of {out}: {name}")

    def series(self, out):
        return numpy.genfromtxt(self.directory / out / "observables.csv", delimiter=",", names=True)

    def assert_fluid_and_rods_keep_momentum(self, out):
        """Both exchange some, and none is lost. Returns the series."""
        series = self.series(out)
        exchanged = max(abs(series[f"fluid_momentum_{axis}kg_ms"]).max() for axis in "xyz")
        self.assertGreater(exchanged, 0.01, out)
        for axis in "xyz":
            kept = series[f"coupled_momentum_{axis}kg_ms"]
            self.assertLess(abs(kept - kept[0]).max(), 1e-12 * max(exchanged, abs(kept[0])), f"{out}: {axis}")
        return series

    def assert_same_series(self, out, whole, besides=()):
        """Bit for bit, but for energies of contacts, which every rank sums on its own before all do."""
        mine, theirs = self.series(out), self.series(whole)
        self.assertEqual(mine.dtype, theirs.dtype)
        for name in mine.dtype.names:
            if name in besides:
                continue
            if name in SUMMED_PER_RANK:
                self.assertLessEqual(numpy.abs(mine[name] - theirs[name]).max(), 1e-12 * numpy.abs(mine[name]).max(), f"{name} of {out}")
            else:
                self.assertTrue(numpy.array_equal(mine[name], theirs[name], equal_nan=True), f"{name} of {out}")

    def assert_layouts_give(self, whole, same):
        """The bits of a run for other ranks x threads and SIMD widths; `same(out)` compares the outputs."""
        def check(out, *arguments, **layout):
            self.run_skein(out, *arguments, **layout)
            self.assertEqual(self.digest(out), self.digest(whole), out)
            same(out)

        for ranks, threads in ((1, 2), (2, 1), (2, 2), (3, 1), (4, 1)):
            check(f"{whole}_{ranks}x{threads}", ranks=ranks, threads=threads)
        for lanes in (1, 2, 4):
            check(f"{whole}_w{lanes}", "--lanes", str(lanes))

    def results(self, out):
        """Content of everything that must not depend on how a run was carried out."""
        folder = self.directory / out
        return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.suffix in (".csv", ".xdmf", ".h5")}
