"""Messages name the cause and a cure that works: the tests follow it."""

import json
import re
import shutil
import subprocess
import unittest

from driver import SKEIN, DriverTest

ROD = """
time.duration = 0.1
load = [{kind = "gravity"}]
damping = [{kind = "uniform", rate = 5.0}]
output = {series = 0.01, checkpoint = 0.05}
[[rods]]
name = "arm"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 20}
placement.tangent = [1.0, 0.0, 0.0]
"""


class Messages(DriverTest):
    def skein(self, *words, code=0):
        done = subprocess.run([SKEIN, *map(str, words)], capture_output=True, text=True, timeout=100, cwd=self.directory)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def said(self, *words, code=2):
        """One line of an error."""
        text = self.skein(*words, code=code).stderr
        self.assertTrue(text.startswith("error: ") and len(text.strip().splitlines()) == 1, text)
        return text[7:].strip()

    def test_commands_and_options_have_nearest_guesses(self):
        for words, expected in ((("rum", "x.toml"), "there is no command 'rum'; did you mean 'run'?"), (("descrbe",), "there is no command 'descrbe'; did you mean 'describe'?"),
                                (("run", "x.toml", "--output", "y"), "skein run has no option '--output'; did you mean '--out'?"),
                                (("run", "x.toml", "--thread=2"), "skein run has no option '--thread'; did you mean '--threads'?"),
                                (("plan", "--jsn", "x.toml"), "skein plan has no option '--jsn'; did you mean '--json'?"),
                                (("xyzzy",), "there is no command 'xyzzy'; skein --help lists all"), (("--versoin",), "skein has no option '--versoin'; did you mean '--version'?"),
                                (("describe", "load.gravty"), "there is no key or table 'load.gravty'; did you mean 'load.gravity'?"),
                                (("describe", "rods.shap"), "there is no key or table 'rods.shap'; did you mean 'rods.shape'?"),
                                (("describe", "rods.shape.lenght", "--json"), "there is no key or table 'rods.shape.lenght'; did you mean 'rods.shape.length'?")):
            with self.subTest(words=words):
                self.assertEqual(self.said(*words), expected)
                near = re.search(r"did you mean '(.*)'", expected)
                if near and words[0] == "describe":
                    self.skein("describe", near[1])
        self.assertIn("SCENE is required", self.skein("run", code=2).stderr)

    def test_every_command_and_option_is_guessed_from_a_slip(self):
        """Of two neighbours that change places, of all words that help names."""
        commands = re.findall(r"^  ([a-z]+) {2,}", self.skein("--help").stdout, re.M)
        self.assertLess({"run", "branch", "verify", "converge", "plan", "check", "describe", "info", "draw", "plot", "export", "doctor"}, {*commands, "x"})
        for command in commands:
            slip = command[0] + command[2] + command[1] + command[3:]
            self.assertIn(f"did you mean '{command}'?", self.said(slip))
            if command in ("draw", "plot", "export", "doctor"):  # of the Python package
                continue
            for option in re.findall(r"^ +(?:-\w,)?(--[a-z-]{4,})", self.skein(command, "--help").stdout, re.M):
                slip = option[:3] + option[4] + option[3] + option[5:]
                if slip != option:
                    self.assertIn(f"did you mean '{option}'?", self.said(command, slip))

    def test_man_page_and_completion_have_every_command_and_option(self):
        manual = self.skein("manual").stdout.replace("\\-", "-")
        script = self.directory / "completion.sh"
        script.write_text(self.skein("completion").stdout)
        for command in re.findall(r"^  ([a-z]+) {2,}", self.skein("--help").stdout, re.M):
            self.assertIn(f".SS skein {command}\n", manual)
            if command in ("draw", "plot", "export", "doctor"):
                continue
            for option in re.findall(r"^ +(?:-\w,)?(--[a-z-]{4,})", self.skein(command, "--help").stdout, re.M):
                self.assertIn(option, manual)
                done = subprocess.run(["bash", "-c", f"source {script}; COMP_WORDS=(skein {command} {option[:-1]}); COMP_CWORD=2; _skein; echo ${{COMPREPLY[*]}}"],
                                      capture_output=True, text=True, check=True)
                self.assertIn(option, done.stdout.split())
        warnings = subprocess.run(["man", "--warnings", "-l", "-"], input=self.skein("manual").stdout, capture_output=True, text=True, check=False) if shutil.which("man") else None
        self.assertEqual(warnings.stderr if warnings else "", "")

    def test_descriptions_as_json_are_those_of_the_page(self):
        whole = json.loads(self.skein("describe", "--json").stdout)
        text = self.skein("describe").stdout
        for key in whole["keys"]:
            self.assertIn(f"`{key['key']}`", text)
            self.assertIn("unit", key)
        self.assertEqual({table["name"] for table in whole["tables"] if table["list"]} & {"time", "contact", "output"}, set())
        one, = json.loads(self.skein("describe", "--json", "rods.shape.length").stdout)["keys"]
        self.assertEqual((one["unit"], one["type"], one["required"]), ("m", "number", True))

    def test_directories_of_results_are_looked_at(self):
        self.scene.write_text(ROD)
        self.run_skein("out", "--until", "0.05")
        for words in (("info", "out"), ("info", "scene.toml", "--out", "out")):
            text = self.skein(*words).stdout
            self.assertRegex(text, r"step \d+ of \d+, 50.0 % done; t = 0.05 s of 0.1 s")
            self.assertIn("group 'arm': rods of 20 elements", text)
        self.assertIn("no checkpoint in out/scene", self.skein("info", "scene.toml").stdout)
        self.assertEqual(f"skein {self.summary('out')['version']}\n", self.skein("--version").stdout)
        described = self.skein("describe", "out").stdout
        (self.directory / "again.toml").write_text(described)
        self.skein("check", "again.toml")
        self.skein("run", "again.toml", "--out", "again", "--until", "0.05", "-q")
        self.assertEqual(self.digest("again"), self.digest("out"))
        (self.directory / "empty").mkdir()
        for command in ("info", "describe"):
            self.assertIn("empty: holds no results", self.skein(command, "empty", code=2).stderr)

    def test_a_directory_that_holds_a_longer_run(self):
        self.scene.write_text(ROD)
        self.run_skein("out")
        short = ("--set", "time.duration=0.02", "--set", "output.checkpoint=0.01")
        text = self.run_skein("out", *short).stdout
        self.assertRegex(text, r"beyond the \d+ steps of the present time.duration")
        self.assertNotRegex(text, r"[0-9]{3,}\.\d % done")
        self.run_skein("shorter", *short)      # the cures: another --out, --overwrite, a longer duration
        self.run_skein("out", "--set", "time.duration=0.12")
        self.run_skein("out", *short, "--overwrite")
        self.assertEqual(self.digest("out"), self.digest("shorter"))

    def test_a_rate_of_0_is_not_an_absent_one(self):
        """In a branch, in its file, and in runs that go on, are branched and verified."""
        self.scene.write_text(ROD)
        self.run_skein("out")
        self.skein("branch", "out", "free", "--set", "damping.0.rate=0", "--set", "time.duration=0.2")
        self.assertIn("rate = 0", (self.directory / "free/scene.toml").read_text())
        self.skein("run", "free", "-q")
        self.skein("verify", "free")
        self.skein("branch", "free", "on", "--set", "time.duration=0.3")
        self.skein("run", "on", "-q")
        self.assertIn("'rate' [1/s] is needed", self.skein("check", "scene.toml", "--set", "damping.0={kind='uniform'}", code=2).stderr)
        for rates in ("translational = 0", "rotational = 0"):
            self.scene.write_text(ROD.replace('{kind = "uniform", rate = 5.0}', f'{{kind = "physical", {rates}}}'))
            out = f"physical_{rates[0]}"
            self.run_skein(out)
            self.skein("branch", out, out + "_on", "--set", "time.duration=0.2")
            self.skein("run", out + "_on", "-q")

    def test_numbers_that_look_like_wrong_units(self):
        self.scene.write_text(ROD)
        self.assertNotIn("note: rods", self.skein("check", "scene.toml").stdout)
        for key, value, said in (("section.radius", "3.0", r"radius = 3 m is 15 times the length of 0.2 m: lengths are in m; were 3 mm meant, write (0\.003)"),
                                 ("shape.length", "200.0", r"length = 200 m is 6.67e\+04 radii of 0.003 m: lengths are in m; were 200 mm meant, write (0\.2)"),
                                 ("material.youngs_modulus", "2.0", r"youngs_modulus = 2 Pa is softer than any jelly: moduli are in Pa; were 2 MPa meant, write (2e\+06)"),
                                 ("material.youngs_modulus", "2e15", r"youngs_modulus = 2e\+15 Pa is stiffer than diamond")):
            with self.subTest(key=key):
                text = self.skein("check", "scene.toml", "--set", f"rods.arm.{key}={value}").stdout
                self.assertRegex(text, said)
                cure = re.search(said, text)
                if cure.groups():
                    self.assertNotIn("were", self.skein("check", "scene.toml", "--set", f"rods.arm.{key}={cure[1]}").stdout)

    def test_units_in_formulas_name_both_operands(self):
        head = ROD.replace('[{kind = "gravity"}]', '[{kind = "formula", per = "length", force = ["FORMULA", "0", "0"]}]\nconstants = {f = {value = 1e-3, unit = "N/m"}, T = {value = 1.0, unit = "s"}, '
                                                   'c = {value = 1.0, unit = "m/s"}}')
        for formula, said, cured in (("f*sin(2*pi*(s/L - t))", r"the parts of a difference need one unit: 's/L' has no unit, 't' is in s; divide 't' by a constant in s", "f*sin(2*pi*(s/L - t/T))"),
                                     ("f*(t + s/L)", r"the parts of a sum need one unit: 't' is in s, 's/L' has no unit; divide 't' by a constant in s", "f*(t/T + s/L)"),
                                     ("f*min(s, t)/L", r"the values of 'min' need one unit: 's' is in m, 't' is in s; multiply 't' by a constant in m/s", "f*min(s, t*c)/L"),
                                     ("f*if(s < t, 1, 2)", r"both sides of a comparison need one unit: 's' is in m, 't' is in s; multiply 't' by a constant in m/s", "f*if(s < t*c, 1, 2)")):
            with self.subTest(formula=formula):
                self.scene.write_text(head.replace("FORMULA", formula))
                self.assertIn(said, self.skein("check", "scene.toml", code=2).stderr)
                self.scene.write_text(head.replace("FORMULA", cured))
                self.skein("check", "scene.toml")

    def test_a_step_that_is_not_the_cause_is_not_named(self):
        """A dead load beyond what the law bears: no step holds, and what is said works."""
        scene = ROD.replace("2e6}", "5e3, shear_modulus = 5e3}").replace('{kind = "gravity"}', '{kind = "end_force", end = [2.0, 0.0, 0.0], ramp = 0.05}')
        self.scene.write_text(scene)
        text = self.run_skein("out", expect=4).stderr
        self.assertIn("likely cause: the loads on the rods, or too few elements; a shorter step does not help", text)
        self.assertNotRegex(text, r"likely cause: dt|--set time\.dt=|KEY=VALUE")
        self.assertIn("#pull-too-strong", text)
        self.assertRegex(text, r'the law "incompressible" supports a pull of at most E A = 0.1414 N: element \d+ is stretched to e = ')
        self.run_skein("weaker", "--set", "load.0.end=[0.02,0,0]")
        self.run_skein("stiffer", "--set", "rods.arm.material.youngs_modulus=1e6", "--set", "rods.arm.material.shear_modulus=3e5")

    def test_a_step_far_beyond_the_limit_is_so_many_times_it(self):
        self.scene.write_text(ROD)
        failed = self.run_skein("out", "--set", "time.dt=5e-3", "--set", "time.force_dt=true", expect=4).stderr
        self.assertRegex(failed, r"likely cause: dt is 44\.\d times the rest-state limit 0\.000111\d* s; lower dt")
        self.assertTrue(failed.endswith("  see docs/troubleshooting.md#strained\n"), failed)

    def test_rods_that_no_end_holds_along_an_axis_are_noted(self):
        self.scene.write_text(ROD)
        said = "no end is held along z, so loads along z move the whole rod"
        slides = ("--set", "rods.arm.start_free=z")
        for words, noted in (((), False), (slides, True), ((*slides, "--set", "rods.arm.end=pinned"), False), ((*slides, "--set", "rods.arm.end=pinned", "--set", "rods.arm.end_free=xz"), True),
                             ((*slides, "--set", "rods.arm.hold.nodes=[3]"), False)):
            with self.subTest(words=words):
                self.assertEqual(said in self.skein("check", "scene.toml", *words).stdout, noted)
        self.scene.write_text(ROD + '[[joint]]\nkind = "spherical"\nbetween = ["arm", "world"]\nat = [1.0]\nstiffness = 1e4\n')
        self.assertNotIn(said, self.skein("check", "scene.toml", *slides).stdout, "the joint holds it")

    def test_shares_of_a_limit_show_their_side_of_it(self):
        limit = float(re.search(r"of the limit ([0-9.e+-]+) s", self.skein("plan", "scene.toml", "--set", "time.dt=1e-3").stdout)[1])
        for share, said in ((0.9997, "0.9997"), (1.0004, "1.0004")):
            text = self.skein("plan", "scene.toml", "--set", f"time.dt={share * limit!r}", "--set", "time.force_dt=true").stdout
            found = re.search(r"([0-9.]+) of (the|its) limit", text)[1]
            self.assertTrue(found.startswith(said[:6]), text)
            self.assertNotEqual(found, "1")


if __name__ == "__main__":
    unittest.main()
