"""Shipped scenes with a mistake in each, run for a few steps: refused with file and line, or, where all keys together make a step that
is too long, with file and rod; or run as told. Never a crash or a hang, and no key that is written wrong goes without a word."""

import collections
import os
import pathlib
import re
import resource
import signal
import subprocess
import unittest

from driver import SKEIN
from faults import ALL, FaultTest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LARGE = {"farm_111797", "nest_1536", "nest_1536_published", "pit_4096", "pit_16384", "swarm_224"}  # as others, with more rods
VALUES = ("0", "-1", "1", "2", "1e300", "-1e300", "1e-300", "nan", "-inf", "0x10", "999999999999", "99999999999999999999", "1e18", '"word"', '""', "[]", "[1, 2]", "[[1]]",
          "{}", "true", "1979-05-27", "''' '''")
BYTES = ("\0", "\x7f", "\ufffd", '"', "'", "[", "]", "{", "}", "=", ".", ",", "#", "\n", "\t", "e", "-", "9", "\\")
KEY = re.compile(r"^(\s*)([A-Za-z_][\w.]*)(\s*=\s*)([^#\n]*?)(\s*(?:#.*)?)$")
CHILD_MEMORY = 6 << 30


class Mutation:
    """Each changes lines of a scene in one place and returns its line number, from 1, where a wrong key must be told; else 0."""

    def __init__(self, draw):
        self.draw = draw

    def keyed(self, lines):
        return self.draw.choice([i for i, line in enumerate(lines) if KEY.match(line)])

    def line_gone(self, lines):
        del lines[self.draw.randrange(len(lines))]

    def line_twice(self, lines):
        at = self.draw.randrange(len(lines))
        lines.insert(at, lines[at])

    def lines_swapped(self, lines):
        a, b = self.draw.randrange(len(lines)), self.draw.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]

    def line_elsewhere(self, lines):
        lines.insert(self.draw.randrange(len(lines)), lines.pop(self.draw.randrange(len(lines))))

    def value(self, lines):
        at = self.keyed(lines)
        lines[at] = KEY.sub(lambda m: m[1] + m[2] + m[3] + self.draw.choice(VALUES) + m[5], lines[at])

    def number(self, lines):
        """One of the numbers in a line, in a list too."""
        at = self.keyed(lines)
        found = list(re.finditer(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?", lines[at]))
        if not found:
            return self.value(lines)
        one = self.draw.choice(found)
        new = self.draw.choice((*VALUES[:10], one[0] + "0", one[0] + "e3", "-" + one[0], one[0] + "e-3"))
        lines[at] = lines[at][: one.start()] + new + lines[at][one.end():]

    def letter(self, lines):
        """A letter of a key doubled, which is never another key."""
        at = self.keyed(lines)
        m = KEY.match(lines[at])
        k = self.draw.randrange(len(m[2].replace(".", "x")))
        if not m[2][k].isalpha():
            return self.letter(lines)
        lines[at] = m[1] + m[2][: k + 1] + m[2][k] + m[2][k + 1:] + m[3] + m[4] + m[5]
        return at + 1

    def header(self, lines):
        at = self.draw.choice([i for i, line in enumerate(lines) if line.startswith("[")])
        lines[at] = self.draw.choice((lines[at].strip("[]"), f"[{lines[at].strip('[]')}]", f"[[{lines[at].strip('[]')}]]", lines[at][:-1], lines[at] + "x",
                                      lines[at].replace("]", ".x]", 1)))

    def byte(self, lines):
        at = self.draw.randrange(len(lines))
        k = self.draw.randrange(len(lines[at]) + 1)
        lines[at] = lines[at][:k] + self.draw.choice(BYTES) + lines[at][k + self.draw.randrange(2):]

    def end_cut(self, lines):
        del lines[self.draw.randrange(len(lines)):]
        if lines:
            lines[-1] = lines[-1][: self.draw.randrange(len(lines[-1]) + 1)]


KINDS = [name for name, member in vars(Mutation).items() if callable(member) and name not in ("__init__", "keyed")]


class Scenes(FaultTest):
    def folder_beside(self, scene):
        """A folder with links to what lies beside a scene."""
        folder = self.directory / scene.stem
        if not folder.exists():
            folder.mkdir()
            for other in scene.parent.iterdir():
                if other != scene:
                    (folder / other.name).symlink_to(other)
        return folder / scene.name

    def run_scene(self, path):
        """Exit code, errors; None for a run that neither ended nor could be stopped."""
        command = [SKEIN, "run", str(path), "--quiet", "--steps", "12", "--no-checkpoint", "--threads", "1", "--overwrite", "--walltime", "20", "--out", str(self.directory / "out")]
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (CHILD_MEMORY, CHILD_MEMORY))
        run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=limit)
        for wait, then in ((25, signal.SIGTERM), (15, signal.SIGKILL)):
            try:
                errors = run.communicate(timeout=wait)[1]
                return run.returncode, errors.decode(errors="replace")
            except subprocess.TimeoutExpired:
                run.send_signal(then)
        run.communicate()
        return None, ""

    def test_mistakes(self):
        scenes = [path for path in sorted(ROOT.glob("apps/*/*.toml")) if path.stem not in LARGE]
        self.assertGreater(len(scenes), 10)
        found, bad = collections.Counter(), []
        for trial in range(500 if ALL else 60):
            scene, kind = self.draw.choice(scenes), KINDS[trial % len(KINDS)]
            lines = scene.read_text().splitlines()
            wrong_key = getattr(Mutation(self.draw), kind)(lines) or 0
            path = self.folder_beside(scene)
            path.write_text("\n".join(lines) + "\n")
            code, errors = self.run_scene(path)
            places = [int(line) for line in re.findall(re.escape(str(path)) + r":(\d+):(?:\d+:)? ", errors)]
            included = re.search(r"^error: \S+\.part:\d+:\d+: ", errors)  # a fault that shows in a file beside it
            if code is None:
                outcome = "hangs"
            elif code in (0, 3):
                outcome = "ran" if not wrong_key else "ran with a wrong key"
            elif code == 2:
                outcome = "refused at a line" if places or included else "refused by its numbers" if f"error: {path}: " in errors and "'" in errors else "too large" if " GB are free" in errors else "refused without a place"
                named = wrong_key and f"did you mean '{KEY.match(lines[wrong_key - 1])[2]}'" in errors  # a constant of formulas is missed where it is used
                if wrong_key and wrong_key not in places and not named and "missing key" not in errors:  # that table's other keys are then not looked at
                    outcome = "refused at another place"
            elif code == 4 and ("rod " in errors or "one of '" in errors or "of the fluid" in errors):  # the second: begun behind a wall
                outcome = "stopped, naming the rod"
            else:
                outcome = f"code {code}"
            found[outcome] += 1
            if outcome not in ("ran", "refused at a line", "refused by its numbers", "too large", "stopped, naming the rod"):
                bad.append(f"{outcome}: {scene.name}, trial {trial}, {kind}\n{errors[-600:]}")
                if os.environ.get("SKEIN_KEEP"):
                    pathlib.Path(os.environ["SKEIN_KEEP"], f"{trial}_{kind}_{scene.name}").write_text(path.read_text())
        print(f"{found.total()} scenes with a mistake: " + ", ".join(f"{count} {outcome}" for outcome, count in found.most_common()))
        self.assertFalse(bad, "\n".join(bad))


if __name__ == "__main__":
    unittest.main()
