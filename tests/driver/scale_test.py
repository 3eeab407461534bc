"""Which units a scene is written in does not matter: lengths, times or masses times a power of two give the same bits, times powers of two.

No product, quotient or square root of such numbers rounds otherwise, so any other bit comes from a constant that is no number of the scene. Units are
those of `skein describe --json`. A key without one fails the test, and so does a kind, or a key with a dimension, that no scene has.
"""

import concurrent.futures
import copy
import csv
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import h5py
import numpy
from driver import SKEIN
from scale_scenes import CSV, FILES, NODES, SCENES
from scene_text import scene_text

BASE = {"m": (1, 0, 0, 0), "s": (0, 1, 0, 0), "kg": (0, 0, 1, 0), "A": (0, 0, 0, 1), "N": (1, -2, 1, 0), "Pa": (-1, -2, 1, 0), "J": (2, -2, 1, 0), "W": (2, -3, 1, 0), "Hz": (0, -1, 0, 0),
        "T": (0, -2, 1, -1), "rad": (0,) * 4, "deg": (0,) * 4, "-": (0,) * 4, "1": (0,) * 4}
SCALES = {f"{what} times 2^{power}": tuple(power * (what == one) for one in ("length", "time", "mass")) for what in ("length", "time", "mass") for power in (24, -24)}

# Keys of wall time, and those that count.
EXEMPT = {"output.checkpoint_wall", "output.frames_wall"}
# Texts that name something; all other texts are formulas and need a unit.
NAMES = {"of", "id", "ignore", "column", "reference", "include", "title", "name", "assembly", "file", "start_free", "end_free", "directions", "axes", "at_unit", "unit", "rods", "along", "between", "open", "watch", "fields",
         "observables", "fluid_forces", "progress", "from", "stages", "until", "change"}
OWN_UNIT = {"table.at", "table.value", "constants.(any name)"}  # of which the scene says the unit
# No choice of physics: files alone; and what needs another library, or other ranks.
NO_PHYSICS = {"output.precision", "output.paraview", "fluid_output.precision", "fluid_output.across", "start.time"}
NOT_HERE = {("fluid.pressure", "multigrid"), ("fluid.pressure_exchange", "interfaces"), ("fluid.along_y", "through"), ("fluid.along_z", "through")}
FORCES = {"length": "N/m", "mass": "N/kg", "rod": "N"}
COUPLES = {"length": "N m/m", "mass": "N m/kg", "rod": "N m"}


def dimensions(unit):
    """Powers of m, s, kg and A."""
    total = [0.0] * 4
    above, _, below = unit.partition("/")
    for sign, words in ((1, above), (-1, below)):
        for word in words.split():
            name, _, power = word.partition("^")
            for i, of_base in enumerate(BASE[name]):
                total[i] += sign * float(power or 1) * of_base
    return total


class Units:
    """Of all keys, by their paths as `describe --json` has them."""

    def __init__(self):
        text = subprocess.run([SKEIN, "describe", "--json"], check=True, capture_output=True, text=True).stdout
        self.keys = {entry["path"]: entry for entry in json.loads(text)["keys"]}
        assert len(self.keys) > 400

    def faults(self):
        """Keys whose numbers or formulas have no unit."""
        for path, entry in self.keys.items():
            is_text = entry["type"] in ("text", "list of texts")
            if entry["type"] in ("choice", "table", "true or false") or path in OWN_UNIT or (is_text and entry["key"] in NAMES and entry["unit"] == ""):
                continue
            if path.startswith("load.formula.") and entry["key"] in ("force", "couple"):
                continue  # their unit goes by `per` and `at`
            for unit in re.split(", | or ", entry["unit"] or "none"):
                try:
                    dimensions(unit)
                except KeyError:
                    yield f"{path}: no unit that can be read: '{entry['unit']}'"

    def has_dimension(self, path):
        units = re.split(", | or ", self.keys[path]["unit"] or "-")
        return self.keys[path]["type"] not in ("choice", "table") and any(any(dimensions(unit)) for unit in units)

    def unit(self, path, table):
        """Of a key of a table, whose other keys may decide."""
        if path == "load.formula.force":
            return FORCES["rod" if table.get("at", "rod") != "rod" else table.get("per", "length")]
        if path == "load.formula.couple":
            return COUPLES["rod" if table.get("at", "rod") != "rod" else table.get("per", "length")]
        unit = self.keys[path]["unit"]
        if path.startswith("joint.") and " or " in unit:  # of a turn or of a way; a motor's table knows its joint's kind
            turns = (table["of"] if "of" in table else table["kind"]) in ("hinge", "universal", "spherical")
            choices = re.split(", | or ", unit)
            of_motor = ("position", "rate", "force").index(table["kind"]) if re.search(r"motor\.values?$", path) else 0
            return choices[of_motor] if path.endswith("values") else choices[2 * of_motor + (0 if turns else 1)]
        if ", " in unit:
            return unit.split(", ")[table.get("law", "hertz") == "hertz"]
        if " or " in unit:
            return unit.split(" or ")[table.get("criterion", "q") != "q"]
        return unit


# Published damping of spin has the factor 1 m^2 (docs/theory.md 7): the one law in which metres are written.
IN_METRES = {"legacy"}


def leaves_out(scene, scale):
    """Whether a scene is not held against another unit."""
    return scene in IN_METRES and scale.startswith("length")


VARIABLES = {"m": ("x", "y", "z", "s", "L", "X", "Y", "Z"), "m/s": ("vx", "vy", "vz"), "s": ("t",)}


class Scaled:
    """A scene in other units."""

    def __init__(self, units, scene, powers):
        self.units, self.powers = units, powers
        self.relaxes = scene["time"].get("relax", False)
        self.constants = {name: value["unit"] for name, value in scene.get("constants", {}).items() if isinstance(value, dict)}
        self.tables = {table["name"]: (table.get("at_unit", "s"), table.get("unit", "-")) for table in scene.get("table", [])}
        self.scene = self.of_table(scene, "")

    def factor(self, unit):
        power = sum(d * p for d, p in zip(dimensions(unit), self.powers))
        assert power == int(power), unit
        return 2.0 ** power

    def numbers(self, value, factor):
        if isinstance(value, list):
            return [self.numbers(item, factor) for item in value]
        return value if isinstance(value, (str, bool)) else value * factor

    def formula(self, text, unit):
        """In the names of before, each brought back to its unit: what is scaled is all that comes in and goes out."""
        if isinstance(text, list):
            return [self.formula(item, unit) for item in text]
        of_name = {name: kind for kind, names in VARIABLES.items() for name in names} | self.constants
        out, i = "", 0
        while i < len(text):
            word = re.match(r"[A-Za-z_]\w*|[0-9.]+(?:[eE][+-]?[0-9]+)?|.", text[i:]).group()
            i += len(word)
            if word in self.tables:
                depth, end = 0, i
                while depth or end == i:
                    depth += {"(": 1, ")": -1}.get(text[end], 0)
                    end += 1
                argument = self.formula(text[i + 1:end - 1], "-")
                at, value = self.tables[word]
                word = f"({word}({self.factor(at)!r}*({argument}))/{self.factor(value)!r})"
                i = end
            elif word in of_name:
                word = f"({word}/{self.factor(of_name[word])!r})"
            out += word
        return out if unit == "-" else f"{self.factor(unit)!r}*({out})"

    def of_table(self, table, path):
        scaled = {}
        for key, value in table.items():
            of_key = f"{path}.{key}" if path else key
            if of_key == "constants":
                scaled[key] = {name: one | {"value": one["value"] * self.factor(one["unit"])} if isinstance(one, dict) else one for name, one in value.items()}
            elif of_key in ("load", "damping") and path == "":
                scaled[key] = [self.of_table(one, f"load.{one['kind']}" if key == "load" else key) for one in value]
            elif of_key == "joint.about_second":
                scaled[key] = {name: one for name, one in self.of_table(value | {"of": table["kind"]}, of_key).items() if name != "of"}
            elif of_key == "joint.about_second.of":
                scaled[key] = value
            elif of_key.startswith("joint.") and key == "motor":
                scaled[key] = {name: self.of_key(f"{of_key}.{name}", one, value | {"of": table.get("of", table.get("kind"))}) for name, one in value.items()}
            elif isinstance(value, dict):
                scaled[key] = self.of_table(value, of_key)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                scaled[key] = [self.of_table(one, of_key) for one in value]
            elif of_key in ("table.at", "table.value"):
                scaled[key] = self.numbers(value, self.factor(table.get("at_unit", "s") if key == "at" else table.get("unit", "-")))
            else:
                scaled[key] = self.of_key(of_key, value, table)
        return scaled

    def of_key(self, path, value, table):
        entry = self.units.keys[path]
        steps = self.relaxes and path.startswith("time.")  # whose time counts steps
        if entry["type"] in ("choice", "true or false", "integer", "integers") or path in EXEMPT or steps:
            return value
        if entry["type"] in ("text", "list of texts"):
            unit = self.units.unit(path, table)
            return value if unit == "" else self.formula(value, unit)
        return self.numbers(value, self.factor(self.units.unit(path, table)))


def run(directory, scaled, steps):
    """Runs a scene; {what: (unit, numbers)} of its end, the unit absent of numbers that have several."""
    directory.mkdir(parents=True)
    for name, text in FILES.items():
        (directory / name).write_text(text)
    columns = [[repr(x * scaled.factor(unit)) for x in values] for _, unit, values in CSV]
    (directory / "rods.csv").write_text("\n".join([",".join(name for name, _, _ in CSV), *map(",".join, zip(*columns))]) + "\n")
    with h5py.File(directory / "traced.h5", "w") as file:
        file["nodes"] = scaled.factor("m") * numpy.array(NODES)
    (directory / "scene.toml").write_text(scene_text(scaled.scene))
    command = [SKEIN, "run", str(directory / "scene.toml"), "--out", str(directory / "out"), "--threads", "1", "--quiet", *(["--steps", str(steps)] if steps else [])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200)
    if done.returncode:
        raise RuntimeError(done.stdout + done.stderr)
    found = {}
    out = directory / "out"
    summary = json.loads((out / "summary.json").read_text())
    found["steps"] = ("-", numpy.array([summary["steps"]]))
    found["dt"] = ("-" if scaled.relaxes else "s", numpy.array([summary["dt_s"]]))
    for name, value in summary["observables"].items():
        if scaled.relaxes and re.match("kinetic|momentum|max_speed", name):
            continue  # of steps of 1 s
        unit = re.search(r"\[(.*)\]", name).group(1)
        found[f"observable {name}"] = (unit or "-", numpy.array([value]))
    with h5py.File(sorted(out.glob("checkpoint_*.h5"))[-1]) as file:
        for group in file.get("groups", {}):
            state = file[f"groups/{group}/state"][:]
            for name, unit, columns in (("position", "m", slice(0, 3)), ("velocity", "m/s", slice(3, 6)), ("quaternion", "-", slice(6, 10)), ("spin", "1/s", slice(10, 13))):
                if scaled.relaxes and unit.endswith("s"):
                    continue
                found[f"{group} {name}"] = (unit, state[..., columns])
    return found


class Scale(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.units = Units()

    def test_every_key_has_a_unit(self):
        self.assertEqual(list(self.units.faults()), [])

    def test_scenes_have_every_kind_and_every_dimension(self):
        given, chosen = set(), set()

        def alike(path):
            """One path for keys that several tables share."""
            path = re.sub(r"^(bodies|assembly)\.placement", "rods.placement", path)
            path = path.replace("end_motion", "start_motion").replace("rods.end", "rods.start") if path in ("rods.end", "rods.end_free") else path.replace("end_motion", "start_motion")
            if re.match(r"(contact_pair|wall)\.", path) and f"contact.{path.split('.', 1)[1]}" in self.units.keys:
                path = f"contact.{path.split('.', 1)[1]}"
            path = path.replace("joint.about_second.", "joint.")
            return re.sub(r"^load\.\w+\.(ramp|onset|ramp_shape)$", r"load.*.\1", path)

        def look(table, path):
            for name, entry in self.units.keys.items():
                if entry["table"] == path and entry["type"] == "choice" and entry.get("default"):
                    chosen.add((alike(name), json.loads(entry["default"])))
            for key, value in table.items():
                of_key = f"{path}.{key}" if path else key
                if of_key == "constants":
                    continue
                for one in value if isinstance(value, list) and value and isinstance(value[0], dict) else [value]:
                    if isinstance(one, dict):
                        look(one, f"load.{one['kind']}" if of_key == "load" else of_key)
                    elif self.units.keys[of_key]["type"] == "choice":
                        chosen.add((alike(of_key), one))
                given.add(alike(of_key))
                if path.startswith("load.") and key == "kind":
                    chosen.add(("load.kind", value))

        for scene, _ in SCENES.values():
            look({"output": {}} | scene, "")
        missing = set()
        for path, entry in self.units.keys.items():
            one = "load.kind" if re.fullmatch(r"load\.\w+\.kind", path) else alike(path)
            if path in EXEMPT or path in NO_PHYSICS or path.startswith(("output.", "start.")):
                continue
            if entry["type"] == "choice":
                missing |= {f"{one} = {choice}" for choice in entry["choices"] if (one, choice) not in chosen and (one, choice) not in NOT_HERE}
            elif self.units.has_dimension(path) and one not in given:
                missing.add(one)
        self.assertEqual(sorted(missing), [], "no scene has these")

    def test_bits_do_not_depend_on_units(self):
        wanted = os.environ.get("SCALE_SCENES", "").split(",") if os.environ.get("SCALE_SCENES") else list(SCENES)
        with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(2) as pool:
            def one(name, scale, powers):
                scene, steps = copy.deepcopy(SCENES[name])
                scaled = Scaled(self.units, scene, (*powers, 0))
                return scaled, pool.submit(run, pathlib.Path(folder, name, scale.replace(" ", "_")), scaled, steps)

            runs = {name: {scale: one(name, scale, powers) for scale, powers in {"as it is": (0, 0, 0), **SCALES}.items()
                           if not leaves_out(name, scale)} for name in wanted}
            for name, scales in runs.items():
                try:
                    plain = scales["as it is"][1].result()
                except RuntimeError as error:
                    self.fail(f"{name}: {error}")
                self.assertGreater(len(plain), 2, name)
                for scale in scales.keys() - {"as it is"}:
                    scaled, future = scales[scale]
                    with self.subTest(scene=name, scale=scale):
                        found = future.result()
                        self.assertEqual(found.keys(), plain.keys())
                        differ = [what for what, (unit, numbers) in found.items()
                                  if not numpy.array_equal(numbers, plain[what][1] * scaled.factor(unit), equal_nan=True)]
                        self.assertEqual(differ, [])


if __name__ == "__main__":
    unittest.main()
