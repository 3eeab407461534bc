"""Scenes that came out wrong, silent or misleading once: each is right now, or refused or stopped with its cause, and the cure that is printed works.

A row of FOUND says what is to come of a scene of tests/data/found: `right`, a measure of its results with the value that is known and how far it may be
from it; `code` and `said`, the exit code and a pattern of the message; `cure`, what somebody who follows the message sets (where it is text, the pattern's
groups go into it), with which the same scene has to hold: to its end, or beyond the time of the failure.
"""

import pathlib
import re
import tomllib
import unittest
from dataclasses import dataclass, field

import h5py
import numpy

from driver import DriverTest, launch

SCENES = pathlib.Path(__file__).resolve().parents[1] / "data/found"
ELEMENTS, STIFFER = "twice the elements", "ten times youngs_modulus"  # in all rods
HOLDS = r"the same steps hold with time\.dt = ([0-9.e+-]+): it was tried"
OVERLAP = r"overlap at the start by [0-9.]+ of the diameter, and .*allow_overlap = true in \[contact\]"
GAINED = r"rods without damping may have gained energy.*time\.dt = ([0-9.e+-]+) holds"
MOST_CURES = 2  # one after the other
RIGID = r"they bend as if [0-9.e-]+ m of them were rigid; stiffness = \"auto\" without a torsional_stiffness bends there as within a rod"
SHOCK = r"starts with a shock, of up to 1[0-9.]+ m/s.*a factor such as ramp\(t, T\) in a formula"
NO_STEP = r"likely cause: the loads on the rods, or too few elements; a shorter step does not help"


@dataclass
class Row:
    code: int = 0
    said: str = ""
    cure: list = field(default_factory=list)
    right: object = None          # of the test, as a function of it and of the folder of results
    cured: object = None          # the same of the run with the cure
    until: float = None           # of the run with the cure, s; 0: to its end
    flags: tuple = ()
    settings: list = field(default_factory=list)  # so that it takes little time


def holds(settings=(), **more):
    return Row(4, HOLDS, ["time.dt={1}"], settings=list(settings), **more)


def overlapping(until=0.0):
    """Random scenes that begin with an overlap; `until`: to a time at which another fault would show."""
    return Row(2, OVERLAP, ["contact.allow_overlap=true"], until=until)


def too_strong(*cure, **more):
    return Row(4, NO_STEP, list(cure), **more)


def column(path, name):
    """Of observables.csv."""
    table = numpy.genfromtxt(path / "observables.csv", delimiter=",", names=True, deletechars="")
    return table[next(heading for heading in table.dtype.names if heading.split("[")[0] == name)]


def positions(path, group):
    """Of all frames [frames, rods, nodes, 3], those of the end too."""
    parts = []
    for segment in sorted(path.glob("trajectory_*.h5")) + sorted(path.glob("end_*trajectory*.h5")):
        with h5py.File(segment) as file:
            parts.append(file[f"groups/{group}/position"][:])
    return numpy.concatenate(parts)


def flies_on(test, path):
    """Nothing touches it, so that its speed of 1 cm/s stays."""
    x = positions(path, "rod")[..., 0].mean(axis=(1, 2))
    test.assertAlmostEqual((x[-1] - x[0]) / (0.01 * 0.002), 1, delta=1e-6)


def capstan(test, path):
    """Tensions of both ends over each other, late: exp(0.4 pi R/(R + r)). The law pulls by EA (1 - 1/e)."""
    late = positions(path, "a")[-10:, 0]
    stretch = numpy.linalg.norm(numpy.diff(late, axis=1), axis=2) * 60 / 1.137743308678728
    pull = (1 - 1 / stretch).mean(axis=0)
    test.assertAlmostEqual(pull[-1] / pull[0] / 3.45, 1, delta=0.03)


def bounced(test, path):
    left, right = (positions(path, name)[-1, 0, 0, 0] for name in ("left", "right"))
    test.assertLess(left, right - 1.9e-3)


def stayed_above(test, path):
    """The striker of the target, both at their middles."""
    target, striker = (positions(path, name)[:, 0, 5, 2] for name in ("target", "striker"))
    test.assertGreater((striker - target).min(), 1e-5)
    test.assertLess((striker - target).min(), 1e-4)


def at_rest(test, path):
    """The last frame has the tip of the closed form F L^3/(3 E I0) r0/r1."""
    test.assertAlmostEqual(positions(path, "rod")[-1, 0, -1, 2] / 4.24413e-3, 1, delta=1e-3)


def elastic_meeting(test, path):
    """The energy of both rods and of their contact stays."""
    energy = sum(column(path, name) for name in ("kinetic_translation", "kinetic_rotation", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist", "contact_energy"))
    test.assertLess(abs(energy / energy[0] - 1).max(), 1e-3)


def automatic(joints):
    return [setting for j in range(joints) for setting in (f"joint.{j}.stiffness='auto'", f"joint.{j}.torsional_stiffness=0")]


def frame_lengthens(test, path):
    """Along its diagonal by F L^3/(24 EI)."""
    corners = [positions(path, name)[:, 0, 0] for name in "ac"]
    diagonal = numpy.linalg.norm(corners[1] - corners[0], axis=1)
    force, stiffness = 7e-6 * 2**0.5, 1e6 * numpy.pi * 2e-3**4 / 4
    test.assertAlmostEqual((diagonal[-1] - diagonal[0]) / (force * 1e-3 / (24 * stiffness)), 1, delta=0.01)


def links_bend(links):
    """The first so many of two links of 0.2 m are arcs of the curvature M/EI."""

    def tip(test, path):
        curvature, length = 0.0125 / (1e6 * numpy.pi * 0.01**4 / 4), 0.2
        angle = links * curvature * length
        at = (1 - numpy.cos(angle)) / curvature + (2 - links) * length * numpy.sin(angle)
        test.assertAlmostEqual(positions(path, "fore")[-1, 0, -1, 0] / at, 1, delta=0.005)

    return tip


def keeps_energy(test, path):
    defect, work = column(path, "energy_defect"), column(path, "work_loads")
    test.assertLess(abs(defect).max(), 0.01 * abs(work).max())


FOUND = {
    "bigforce": Row(4, r"likely cause: the loads on the rods; they would take steps of [0-9.e-]+ s.*weaken the load", ["constants.f.value=1e-33"]),
    "balls_pass": Row(4, r"contact\.collision_time = ([0-9.e+-]+) in place of 0\.01", ["contact.collision_time={1}"], until=0, cured=bounced),
    "rods_pass": Row(4, r"contact\.stiffness = ([0-9.e+-]+) in place of 0\.1", ["contact.stiffness={1}"], until=2e-5, settings=["output.trajectory=1e-6"], cured=stayed_above),
    "relax_without_its_end": Row(right=at_rest),
    "energy_gain_33to1": Row(right=elastic_meeting),
    "mixed_radii": Row(right=elastic_meeting),
    "plate_one_cell_deep_bug": Row(flags=("--until", "0.05")),
    "stress_rod many sweeps": Row(settings=["immersion.sweeps=20"], flags=("--until", "1.4")),
    "stress_rod leaves": Row(4, r"has left the fluid through its upper face across x.*time\.duration = ([0-9.]+)", ["time.duration={1}"], until=0, settings=[
        "fluid.cells=[24,24,24]", "fluid.spacing=0.083333333333333333", 'fluid.along_x="through"', 'fluid.along_y="free_slip"', 'fluid.along_z="free_slip"', "fluid.inflow=[1,0,0]", "time.duration=3"]),
    "m12": [Row(2, OVERLAP, ["contact.allow_overlap=true"], flags=("--until", "0.01")), holds()],
    "capstan_regularised": Row(2, r"of its diameter deep in the wall .*allow_overlap = true", ["wall.0.allow_overlap=true"], cured=capstan),
    "hover": Row(right=flies_on),
    "packing_stops": Row(flags=("--until", "0.004")),
    "frame_fixed_joints": Row(0, RIGID, automatic(4), until=0, cured=frame_lengthens),
    "d_joint_couple": Row(0, RIGID, automatic(2), until=0, cured=links_bend(2)),
    "d_joint_muscle": Row(0, RIGID, automatic(2), until=0, cured=links_bend(1)),
    "e_swim": Row(0, SHOCK, ["load.0.curvature=['0', 'ramp(t, 0.5*T)*4*sin(2*pi*(s/L - t/T))', '0']"], flags=("--until", "0.02"), until=0.02),
    "e_ramp": Row(flags=("--until", "0.1")),  # how far it swims: driver.exchange
    "fuzz_22": holds(),
    "fuzz_48": too_strong(STIFFER),
    "fuzz_115": overlapping(),
    "fuzz_120": overlapping(),
    "fuzz_131": overlapping(1e-6),
    "fuzz_146": overlapping(0.03),
    "fuzz_160": overlapping(),
    "fuzz_173": too_strong(ELEMENTS),
    "fuzz_178": too_strong(ELEMENTS),
    "fuzz_189": overlapping(),
    "fuzz_192": [overlapping(), too_strong(ELEMENTS)],
    "fuzz_30": Row(0, GAINED, ["time.dt={1}"], cured=keeps_energy),
    "fuzz_182": Row(0, GAINED, ["time.dt={1}"], cured=keeps_energy),
}


class Found(DriverTest):
    def run_scene(self, name, out, settings, flags=()):
        words = [word for setting in settings for word in ("--set", setting)]
        return launch("run", SCENES / f"{name.split()[0]}.toml", "--out", self.directory / out.replace(" ", "_"), "--threads", "1", *flags, *words, timeout=250)

    def check(self, name):
        """A scene whose cure shows another fault has a second row for that, whose cure comes on top."""
        rows = FOUND[name] if isinstance(FOUND[name], list) else [FOUND[name]]
        settings, flags, out = list(rows[0].settings), rows[0].flags, name
        for cures in range(MOST_CURES + 1):
            done = self.run_scene(name, out, settings, flags)
            told = " ".join((done.stdout + done.stderr).split())
            row = rows[min(cures, len(rows) - 1)]
            if cures > 0 and done.returncode in (0, 3):
                self.assertNotRegex(told, earlier.said)
                if earlier.cured:
                    earlier.cured(self, self.directory / out.replace(" ", "_"))
                return
            self.assertEqual(done.returncode, row.code, f"{settings}: {done.stderr}")
            self.assertTrue(re.search(row.said, told), f"{settings}: no {row.said} in {done.stdout}{done.stderr}")
            if row.right:
                row.right(self, self.directory / name.replace(" ", "_"))
            if not row.cure:
                self.assertEqual(row.code, 0, "a refusal without a cure")
                return
            groups = (None, *re.search(row.said, told).groups())
            settings += [setting.format(*groups) for setting in row.cure if setting not in (ELEMENTS, STIFFER)]
            for group in tomllib.loads((SCENES / f"{name.split()[0]}.toml").read_text()).get("rods", []):
                if ELEMENTS in row.cure:
                    settings.append(f"rods.{group['name']}.shape.elements={2 * group['shape']['elements']}")
                if STIFFER in row.cure:
                    settings.append(f"rods.{group['name']}.material.youngs_modulus={10 * group['material']['youngs_modulus']}")
            failed = re.search(r"\(t = ([0-9.e+-]+) s", done.stderr)
            until = row.until if row.until is not None else 1.02 * float(failed[1]) if failed else 0
            flags = ("--until", repr(until)) if until else row.flags
            earlier, out = row, f"{name}_cured_{cures + 1}"
        self.fail(f"{settings}: exit code {done.returncode}: {done.stderr}")

    def test_every_scene_has_a_row(self):
        self.assertEqual({name.split()[0] for name in FOUND}, {path.stem for path in SCENES.glob("*.toml")})


def add_tests():
    for name in FOUND:
        setattr(Found, f"test_{name.replace(' ', '_')}", lambda self, name=name: self.check(name))


add_tests()
if __name__ == "__main__":
    unittest.main()
