"""docs/tutorial_*.md, typed from top to bottom in an empty home: every command ends as the page announces, and its numbers are in the output."""

import resource
import sys
import unittest

from package import ROOT, SKEIN

sys.path.insert(0, str(ROOT / "tests/package"))
from typed import Typed, untrue  # noqa: E402

MOST_SECONDS = 150  # of processors: a page is typed in a minute on two idle cores


def used():
    """Seconds of processors that ended commands have taken."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class Tutorials(unittest.TestCase):
    def typed(self, name, files):
        text = (ROOT / f"docs/tutorial_{name}.md").read_text()
        shell = Typed(ROOT, SKEIN, sys.executable)
        self.addCleanup(shell.close)
        began = used()
        shell.page(text)
        seconds = used() - began
        print(f"{name}: {seconds:.0f} s")
        self.assertLess(seconds, MOST_SECONDS)
        self.assertEqual(untrue(text, shell.output, shell.typed), [])
        for file in files:
            self.assertGreater((shell.place / file).stat().st_size, 5000, file)

    def test_statics(self):
        self.typed("statics", ["out/cantilever/picture.png", "out/swing/series.png", "swing.gif"])

    def test_contact(self):
        self.typed("contact", ["out/cross/picture.png", "out/pile/series.png", "pile.gif"])

    def test_traced(self):
        self.typed("traced", ["out/dish/picture.png", "out/knit/picture.png", "tree.gif"])


class Numbers(unittest.TestCase):
    PAGE = "The tip is at 0.183 m.\n\n```\nprint\n```\n\n```text\ntip 0.183 after ... s\n```\n"

    def test_true(self):
        self.assertEqual(untrue(self.PAGE, "tip 0.183 after 0.7 s\n", "print\n"), [])

    def test_other_numbers_and_lines_are_found(self):
        self.assertEqual(untrue(self.PAGE, "tip 0.184 after 0.7 s\n", "print\n"), ["0.183", "tip 0.183 after ... s"])
        self.assertEqual(untrue(self.PAGE.replace("m.", "m, or 0.1829."), "tip 0.183 after 0.7 s\n", ""), ["0.1829"])


if __name__ == "__main__":
    unittest.main()
