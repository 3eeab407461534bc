"""What a scene writes does not change what happens in it: with `time.dt` or `time.divide` given, every shipped scene has the same digest under five
[output] tables. Cut to 500 steps, with a fluid to about 20 of its steps, to 12 where rods take hundreds in each; large scenes to fewer rods or
coarser cells, as outputs come at steps whatever the size."""

import concurrent.futures
import json
import pathlib
import re
import subprocess
import tempfile
import unittest

from driver import SKEIN

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
MOST_CELLS = 60_000  # more are made coarser until there are fewer

# Thousands of rods need seconds to be packed, and would be stepped five times.
SMALLER = {
    **{f"pit_{name}": ["rods.snakes.placement.count=128"] for name in ("1024", "1024_friction", "1024_published", "4096", "16384")},
    **{f"nest_{name}": ["rods.sticks.placement.count=128"] for name in ("460", "1536", "1536_published")},
    **{f"school_32{name}": ["rods.swimmer.placement.counts=[1,2,2]"] for name in ("", "_moving")},
}
MASKED = {"farm_111797": "rods.cilia.placement.file", "swarm_224": "assembly.bot.placement.file"}  # a smaller mask: four of them


def settings(*keys):
    return [f"--set={key}" for key in keys]


def plan_of(scene, keys):
    done = subprocess.run([SKEIN, "plan", scene, "--json", "--threads", "1", *settings(*keys)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{scene.stem}: {done.stderr}")
    return json.loads(done.stdout)


def coarser(text, plan, keys):
    """Twice the spacing, as often as it takes."""
    fluid, times = plan["fluid"], 1
    count = fluid["cells"][0] * fluid["cells"][1] * fluid["cells"][2]
    while count > MOST_CELLS and min(fluid["cells"]) >= 16:
        times, count = 2 * times, count / 8
    if times == 1:
        return keys
    keys = [*keys, f"fluid.spacing={times * fluid['spacing']!r}"]
    if re.search(r"^cells = ", text, re.M):
        keys.append(f"fluid.cells={[n // times for n in fluid['cells']]}")
    return keys


def tables(plan, text, dt, steps, others):
    """Five [output] tables for a run of so many steps of dt; the first has outputs at its ends alone. `others`: names of [[fluid_output]]."""
    whole = plan["steps"] * plan["dt"] / dt * (1 - 1e-6)
    part = lambda of_500: max(1, round(of_500 * steps / 500))
    made = [{}, {"series": part(7)}, {"tips": part(11), "series": part(90), "trajectory": part(250)}, {"checkpoint": part(60), "series": part(60)},
            {"series": part(50)}]
    nothing = {"series": whole, "checkpoint": 0}
    if plan["rods"] > 0: nothing |= {"tips": whole, "trajectory": whole}
    if "[contact]" in text: made[4]["contacts"] = part(100)
    if plan.get("fluid"): made[4]["fields"] = part(90)
    for i, table in enumerate(made):
        yield [*(f"output.{key}={steps * dt!r}" for key, steps in {**nothing, **table}.items() if key in {*nothing, "contacts", "fields"}),
               *(f"fluid_output.{name}.every={(whole if i == 0 else part(13 * i)) * dt!r}" for name in others)]


class Outputs(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.mask = pathlib.Path(directory.name, "four.pbm")
        self.mask.write_text("P1\n2 2\n1 1\n1 1\n")

    def digest(self, scene, steps, keys):
        with tempfile.TemporaryDirectory() as out:
            done = subprocess.run([SKEIN, "run", scene, "-q", "--steps", str(steps), "--threads", "1", "--out", out, *settings(*keys)],
                                  capture_output=True, text=True, check=False)
            summary = pathlib.Path(out, "summary.json")
            if not summary.exists(): raise AssertionError(f"{scene.stem} {keys}: {done.stderr}")
            return json.loads(summary.read_text())["digest"]

    def digests(self, scene, given):
        """Under each table, with `time.dt` or `time.divide` given."""
        text = scene.read_text() + ((scene.parent / "swimmer.part").read_text() if "swimmer.part" in scene.read_text() else "")
        keys = SMALLER.get(scene.stem, [])
        if scene.stem in MASKED: keys = [f"{MASKED[scene.stem]}='{self.mask}'"]
        plan = plan_of(scene, keys)
        if plan.get("fluid"):
            keys = coarser(text, plan, keys)
            plan = plan_of(scene, keys)
        dt, steps = plan["dt"], min(500, plan["steps"])
        if plan.get("fluid") and plan["rods"]:
            every = plan["fluid"]["meets_rods_every"]
            steps = (12 if every >= 100 else 20) * every  # the most frequent table has six outputs in a step of the fluid, others one or fewer
        elif plan.get("fluid"):
            per_step = max(1.0, plan["fluid"]["steps"] / plan["steps"])
            dt, steps = dt / per_step, 20
        if "relax = true" in text: given = None  # it chooses its steps
        if "\ntolerance = " in text and given: given = "divide"  # which cuts steps by itself
        if given: keys = [*keys, f"time.dt={dt!r}" if given == "dt" else f"time.divide={40 * dt!r}"]
        others = re.findall(r'\[\[fluid_output\]\]\s*name = "(\w+)"', text)
        return [self.digest(scene, steps, [*keys, *table]) for table in tables(plan, text, dt, steps, others)]

    def test_do_not_change_what_happens(self):
        scenes = sorted(APPS.rglob("*.toml"))
        self.assertGreater(len(scenes), 50)
        # Both ways where they cost little; a fluid with rods by `dt`, whose steps a given one leaves to count.
        cases = [(scene, given) for i, scene in enumerate(scenes) for given in (["dt"] if "[fluid]" in scene.read_text() or i % 2 else ["divide"])]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            found = [pool.submit(self.digests, scene, given) for scene, given in cases]
            for (scene, given), digests in zip(cases, found):
                with self.subTest(scene=scene.stem, given=given):
                    self.assertEqual(len(set(digests.result())), 1, digests.result())


if __name__ == "__main__":
    unittest.main()
