"""Every table of the scene reference has an example, which `skein check` accepts in a scene round it.

    examples_test.py SKEIN
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

SKEIN = pathlib.Path(sys.argv[1]).resolve()
ROD = 'material = {density = 1200.0, youngs_modulus = 2e6}\nsection.radius = 3e-3\nshape = {length = 0.1, elements = 20}\n'
ROUND = f"""
time.duration = 1.0
damping = [{{kind = "uniform", rate = 5.0}}]
output.series = 0.1
[[rods]]
name = "arm"
start = "clamped"
placement.origin = [0.0, 0.0, 0.1]
{ROD}
[[rods]]
name = "leg"
placement.origin = [0.0, 0.0, 0.21]
{ROD}
"""
# Tables whose examples an example needs beside it. Those within others need the others too.
NEEDS = {"contact_pair": "contact", "immersion": "fluid", "obstacle": "fluid", "fluid_output": "fluid", "fluid_probe": "fluid", "load.magnetic_field": "rods.magnetisation", "load.magnetic_formula": "rods.magnetisation"}
FEWEST_LINES, MOST_LINES = 2, 15


def merge(scene, more):
    """Lists of tables are appended; a table within a list goes into its first one."""
    for key, value in more.items():
        there = scene.get(key)
        if isinstance(there, list) and isinstance(value, list) and there and isinstance(there[0], dict):
            there += value
        elif isinstance(value, dict) and there is not None:
            merge(there[0] if isinstance(there, list) else there, value)
        else:
            scene[key] = value
    return scene


def toml(value):
    if isinstance(value, dict): return "{" + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list): return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def has_table(scene, table):
    """True if the example has a key of this table, or the table of this kind."""
    at = scene
    for name in filter(None, table.split(".")):
        if isinstance(at, list):
            kinds = [one for one in at if one.get("kind") == name]
            at = kinds or [one[name] for one in at if name in one]
            at = at if kinds else at and at[0]
        else:
            at = at.get(name)
        if not at: return False
    return True


def needed(table, examples):
    parts = table.split(".")
    return ([NEEDS[table]] if table in NEEDS else []) + ([parts[0]] if len(parts) > 1 and parts[0] not in ("rods", "load") else [])


def skein(directory, *words):
    return subprocess.run([SKEIN, *words], cwd=directory, capture_output=True, text=True, check=False)


def problems(directory, examples, table):
    example = examples[table]
    if not FEWEST_LINES <= example.count("\n") <= MOST_LINES:
        yield f"an example of {example.count(chr(10))} lines"
        return
    own = tomllib.loads(example)
    if not has_table(own, table):
        yield "the example has another table"
    scene = tomllib.loads(ROUND)
    for other in needed(table, examples):
        merge(scene, tomllib.loads(examples[other]))
    (directory / "scene.toml").write_text("".join(f"{key} = {toml(value)}\n" for key, value in merge(scene, own).items()))
    done = skein(directory, "check", "scene.toml")
    if done.returncode and not ("built without the solver" in done.stderr and table in ("fluid", "immersion", "obstacle", "fluid_output", "fluid_probe")):
        yield done.stderr


def main(directory):
    (directory / "material.toml").write_text("")
    (directory / "first.toml").write_text(ROUND)
    ran = skein(directory, "run", "first.toml", "--steps", "2", "-q", "--threads", "1")
    assert ran.returncode == 0, ran.stderr
    described = json.loads(skein(directory, "describe", "--json").stdout)
    examples = described["examples"]
    tables = {key["table"] for key in described["keys"]}
    assert len(tables) > 40 and tables == examples.keys(), tables ^ examples.keys()
    assert list(problems(directory, {"time": "[time]\ndurations = 1\n"}, "time")), "a wrong key passes"
    assert list(problems(directory, {"time": "[output]\nseries = 1\n"}, "time")), "another table passes"
    found = [f"{table or 'top level'}: {problem}" for table in sorted(tables) for problem in problems(directory, examples, table)]
    print("\n".join(found) or f"{len(tables)} tables have examples that pass")
    return 1 if found else 0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        sys.exit(main(pathlib.Path(folder)))
