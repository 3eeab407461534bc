"""Commands in blocks of every page: their files are there, their options are those of --help, their scenes take the keys that they set. Scenes in blocks have keys that exist.

Recipes, tutorials, the guide and the tour are typed by tests of their own.
"""

import difflib
import glob
import json
import pathlib
import re
import shlex
import subprocess
import tomllib
import unittest

from package import ROOT, SKEIN

PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "bench/README.md", *ROOT.glob("docs/*.md"), *ROOT.glob("apps/**/*.md")])
LAUNCHERS = {"mpirun", "srun", "mpiexec"}
PLACES = ("apps/", "bench/", "jobscripts/", "tests/", "docs/", "python/", "cmake/")
SHELLS = {"", "sh", "bash"}


def blocks(page):
    """Language and text of each block."""
    return re.findall(r"^```(\w*)\n(.*?)^```", page.read_text(), re.S | re.M)


def commands(text):
    """Words of each line that is a command, without what the shell makes of it."""
    for line in text.replace("\\\n", " ").splitlines():
        try:
            words = shlex.split(line.removeprefix("$ "), comments=True)
        except ValueError:
            continue  # not a command
        while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]): words = words[1:]
        if words: yield words


def scene_keys():
    """Names of tables and keys, in the order of their nesting, as a set of each table's own words."""
    told = json.loads(subprocess.run([SKEIN, "describe", "--json"], capture_output=True, text=True, check=True).stdout)
    return {word for one in [*told["keys"], *told["tables"]] for name in (one.get("table", ""), one.get("key", ""), one.get("name", "")) for word in name.split(".")}


def words_of(scene, free=("constants",)):
    for key, value in scene.items():
        yield key
        if key in free: continue
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, dict): yield from words_of(one)


class Version(unittest.TestCase):
    def test_one_version(self):
        found = {name: re.search(pattern, (ROOT / name).read_text(), re.M).group(1) for name, pattern in (
            ("CMakeLists.txt", r"project\(skein VERSION (\S+)"), ("python/pyproject.toml", r'^version = "(.*)"'), ("CITATION.cff", r"^version: (.*)"),
            ("README.md", r"version = \{(.*?)\}"), ("CHANGELOG.md", r"^## ([\d.]+)"))}
        found["skein"] = subprocess.run([SKEIN, "--version"], capture_output=True, text=True, check=True).stdout.split()[1].rstrip(",")
        self.assertEqual(len(set(found.values())), 1, found)


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._help = {}

    def help(self, *words):
        if words not in self._help:
            done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
            self._help[words] = done.stdout if done.returncode == 0 else ""
        return self._help[words]

    def assert_options(self, options, text, where):
        for option in options:
            self.assertRegex(text, rf"(?<![\w-]){re.escape(option)}(?![\w-])", f"{where}: no option {option}")

    def assert_files(self, words, where):
        for word in words:
            if word.startswith(PLACES) and not re.search(r"[<>…]|\b(NAME|STEM|SCENE)\b", word):
                self.assertTrue(glob.glob(str(ROOT / re.split("[=@]", word)[0])), f"{where}: {word}")

    def assert_known(self, word, where):
        """A word that is nearly a program of the page is one that is misspelt."""
        known = ["build/bin/skein", "skein", "mpirun", "bash", "/usr/bin/python3"]
        self.assertTrue(word in known or not difflib.get_close_matches(word, known, cutoff=0.8), f"{where}: {word}")

    def check(self, words, where, page=""):
        """True if the words are a command of Skein, of a script or of a program that is built."""
        self.assert_files(words, where)
        programs = [i for i, word in enumerate(words) if word.startswith("build/bin/") or word == "skein"]
        if words[0] in LAUNCHERS and programs: words = words[programs[0]:]
        elif words[0] in ("bash", "/usr/bin/python3") and len(words) > 1 and words[1].endswith((".sh", ".py")) and words[1].startswith(PLACES):
            options = [w.partition("=")[0] for w in words[2:] if w.startswith("--")]
            if options:
                self.assertRegex((ROOT / words[1]).read_text(), "take_option|help|argparse|Parser", f"{where}: no --help")
                self.assert_options(options, self.help(*words[:2], "--help"), where)
            return True
        elif not programs or programs[0] != 0:
            self.assert_known(words[0], where)
            return False
        program = pathlib.Path(words[0]).name
        if program != "skein":
            self.assertTrue((pathlib.Path(SKEIN).parent / program).exists(), f"{where}: {program} is not built")
            return True
        if len(words) < 2 or words[1].startswith("-"): return True
        self.assertRegex(self.help(SKEIN, "--help"), rf"(?m)^  {re.escape(words[1])} ", f"{where}: no such command")
        text = self.help(SKEIN, words[1], "--help")
        self.assert_options([w.partition("=")[0] for w in words[2:] if re.match(r"--\w", w)], text, where)
        self.assert_keys(words, where, page)
        return True

    def assert_keys(self, words, where, page):
        """A key that is refused is so on the page as well."""
        scenes = [word for word in words if word.startswith("apps/") and word.endswith(".toml")]
        keys = [words[i + 1] for i, word in enumerate(words[:-1]) if word == "--set"]
        if len(scenes) == 1 and keys and words[1] in ("run", "plan", "check") and not any(re.search(r"[A-Z]{3,}|\$", key) for key in keys):
            done = subprocess.run([SKEIN, "check", scenes[0], *(part for key in keys for part in ("--set", key))], capture_output=True, text=True, cwd=ROOT)
            refusal = done.stderr.partition("\n")[0]
            if done.returncode != 0: self.assertIn(refusal.removeprefix("error: "), page, where)

    def test_commands_of_all_pages(self):
        found = 0
        for page in PAGES:
            for language, text in blocks(page):
                if language not in SHELLS: continue
                for words in commands(text):
                    found += self.check(words, f"{page.relative_to(ROOT)}: {' '.join(words)}", page.read_text())
        print(found, "commands")
        self.assertGreater(found, 150)

    def test_what_is_wrong_is_found(self):
        for line in ("build/bin/skein run apps/nest/nest_1535.toml", "build/bin/skein rum apps/nest/nest_1536.toml", "build/bin/skein run apps/nest/nest_1536.toml --thread 2",
                     "build/bin/bench_nothing", "bulid/bin/skein info", "skien info", "/usr/bin/python3 apps/gallery/movies.py out --frame 3", "bash jobscripts/test.sh --job 2", "build/bin/skein check apps/nest/nest_1536.toml --set time.durations=1"):
            with self.assertRaises(AssertionError, msg=line):
                self.check(shlex.split(line), line)

    def test_keys_of_scenes_in_blocks(self):
        known = scene_keys()
        for page in PAGES:
            for language, text in blocks(page):
                if language == "toml":
                    for word in words_of(tomllib.loads(text)):
                        self.assertIn(word, known, page.relative_to(ROOT))


if __name__ == "__main__":
    unittest.main()
