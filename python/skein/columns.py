"""Tables of solutions: path.csv of `skein path`, modes.csv of `skein modes` (docs/files.md)."""

import csv
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from .needs import Damaged, NotResults, need_files, reading

NUMBER, OF_POINT = 2, 7  # in path.csv: place of the number along the path, and of the first observable
WORDS = {"place", "of"}                                     # columns that are no numbers
WHOLE = {"point", "branch", "negative", "mode", "neutral"}  # columns of whole numbers


class Columns(dict):
    """Columns of path.csv or modes.csv: {name: [rows]}, their `units`; a heading with its unit names a column too."""

    def __init__(self, directory, file, first):
        self.path = Path(directory) / file
        need_files(directory, file)
        with reading(self.path):
            with self.path.open(newline="") as text:
                self.headings, *rows = csv.reader(text)
            if self.headings[0] != first:
                raise Damaged(f"{self.path}: its first line does not begin with '{first}'")
            if any(len(row) != len(self.headings) for row in rows):
                raise Damaged(f"{self.path}: its rows have not as many entries as its first line")
            split = [heading.rstrip("]").split("[") for heading in self.headings]
            self.units = {parts[0]: parts[1] if len(parts) > 1 else "" for parts in split}
            for number, (name, *_) in enumerate(split):
                kind = str if name in WORDS else int if name in WHOLE else float
                self[name] = np.array([kind(row[number]) for row in rows], dtype=kind)

    def __missing__(self, name):
        if name in self.headings:
            return self[name.split("[")[0]]
        guess = get_close_matches(name, self, 1)
        raise NotResults(f"{self.path.parent}: no columns of {self.path.name} called {name}" + (f"; did you mean {guess[0]}?" if guess else f"; there are {', '.join(self)}"))


def path_columns(directory):
    return Columns(directory, "path.csv", "point")


def slope_columns(directory):
    """Columns of observables by numbers of the scene at points, and of the path's number at limit and branch points; None if none were asked for."""
    if not (Path(directory) / "slopes.csv").exists():
        return None
    return Columns(directory, "slopes.csv", "point"), Columns(directory, "critical_slopes.csv", "point")


def modes_columns(directory):
    return Columns(directory, "modes.csv", "mode")
