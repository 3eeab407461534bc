"""Commands with --json print one document on standard output, and nothing else."""

import json
import re
import subprocess
import unittest

from driver import SKEIN, DriverTest

ARM = """
time.duration = 0.02
load = [{kind = "gravity"}]
damping = [{kind = "uniform", rate = 5.0}]
output = {series = 0.01, checkpoint = 0.01, trajectory = 0.01}
[[rods]]
name = "arm"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 6}
placement.tangent = [1.0, 0.0, 0.0]
[[expect]]
column = "kinetic_translation"
value = 1e9
tolerance = 1e-3
reference = "none: it is not met"
"""
# Of commands: words, exit code, and a key of the document (of its first entry, if it is a list). In this order, as some need the results of others.
CALLS = {
    "run": [(("scene.toml", "--out", "out", "--until", "0.01"), 0, "digest"), (("scene.toml", "--out", "out"), 0, "digest"), (("scene.toml", "--out", "out", "--overwrite"), 0, "digest"),
            (("scene.toml", "--out", "out"), 0, "digest")],
    "expect": [(("scene.toml", "--out", "out", "--overwrite"), 9, "met")],
    "verify": [(("out",), 0, "same")],
    "converge": [(("scene.toml", "--dry-run"), 0, "predicted_core_seconds"), (("scene.toml", "--coarser", "--out", "study"), 0, "observables")],
    "equilibrium": [(("scene.toml",), 0, "unknown_stability")],
    "modes": [(("scene.toml", "--count", "2"), 0, "neutral_motions")],
    "path": [(("scene.toml", "--along", "rods.arm.material.youngs_modulus", "--to", "3e6"), 0, "branches")],
    "gradient": [(("scene.toml", "--by", "rods.arm.material.youngs_modulus"), 0, "numbers")],
    "fit": [(("scene.toml", "data.csv", "--number", "rods.arm.material.youngs_modulus"), 0, "misfits")],
    "branch": [(("out", "branch", "--set", "damping.0.rate=4"), 0, "changes")],
    "plan": [(("scene.toml",), 0, "rods"), (("scene.toml", "--ranks", "2"), 0, "forecast")],
    "check": [(("scene.toml",), 0, "dt_s"), (("--self",), 0, "digest")],
    "info": [((), 0, "version"), (("scene.toml",), 0, "lanes"), (("out",), 0, "run")],
    "describe": [((), 0, "keys"), (("rods.shape",), 0, "tables")],
    "new": [((), 0, "purpose"), (("pile",), 0, "file")],
    "plot": [(("out",), 0, "column")],
    "draw": [(("out", "--renderer", "plain", "--size", "64x64"), 0, "file")],
    "export": [(("out", "--to", "rods.csv"), 0, "rods")],
    "doctor": [((), None, "part")],
}
# Text for other programs: man(1) and bash.
WITHOUT = {"manual", "completion"}


class Documents(DriverTest):
    def test_every_command_prints_one_document(self):
        self.scene.write_text(ARM)
        (self.directory / "data.csv").write_text("load.0.ramp,centre_z\n0,-0.0017\n0,-0.0018\n")
        help_text = subprocess.run([SKEIN, "--help"], capture_output=True, text=True, check=True).stdout
        commands = set(re.findall(r"^  ([a-z]+) {2,}", help_text.split("Examples:")[0], re.M))
        self.assertEqual(commands, CALLS.keys() | WITHOUT)
        for command in WITHOUT:
            self.assertEqual(subprocess.run([SKEIN, command, "--json"], capture_output=True, check=False).returncode, 2)
        for command, calls in CALLS.items():
            for words, code, key in calls:
                with self.subTest(command=command, words=words):
                    done = subprocess.run([SKEIN, command, *words, "--json"], capture_output=True, text=True, cwd=self.directory, timeout=100, check=False)
                    if code is not None:
                        self.assertEqual(done.returncode, code, done.stderr)
                    document = json.loads(done.stdout)
                    self.assertIn(key, document[0] if isinstance(document, list) else document)

    def test_a_document_that_cannot_be_written(self):
        self.scene.write_text(ARM)
        with open("/dev/full", "w") as full:
            done = subprocess.run([SKEIN, "check", "scene.toml", "--json"], stdout=full, stderr=subprocess.PIPE, text=True, cwd=self.directory, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("standard output: No space left on device", done.stderr)

    def test_an_error_prints_no_document_and_its_place_on_the_page(self):
        self.scene.write_text(ARM.replace("radius", "radios"))
        for command in ("run", "check", "plan", "converge", "expect"):
            done = subprocess.run([SKEIN, command, "scene.toml", "--json"], capture_output=True, text=True, cwd=self.directory, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertTrue(done.stderr.endswith("\n  see docs/troubleshooting.md#unknown-key\n"), done.stderr)


if __name__ == "__main__":
    unittest.main()
