"""Tables of solutions: path.csv of `skein path`, modes.csv of `skein modes` (docs/files.md)."""

import csv
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from .needs import Damaged, NotResults, need_files, reading
from .program import RunFailed, description
from .results import open as open_results

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
    """Columns of path.csv, with the unit of the number along the path."""
    table = Columns(directory, "path.csv", "point")
    key = list(table)[NUMBER]
    table.units[key] = table.units[key] or _unit(directory, key)
    return table


def modes_columns(directory):
    return Columns(directory, "modes.csv", "mode")


def _unit(directory, key):
    """Unit of a number of the scene: of a constant its own, else the unit of the key; empty if it has none, or keys of one name have several."""
    table, *_ = parts = key.split(".")
    physics = open_results(directory).physics
    if table == "constants":
        constant = physics.get("constants", {}).get(parts[1], {})
        return constant.get("unit", "") if isinstance(constant, dict) else ""
    entries = physics.get(table)
    if isinstance(entries, list) and len(parts) > 2:
        entry = next((entry for number, entry in enumerate(entries) if parts[1] in (str(number), entry.get("name"))), {})
        kind = entry.get("kind", "")
    else:
        kind = ""
    last = next(part for part in reversed(parts) if not part.isdigit())
    try:
        known = [one for one in description()["keys"] if one["path"].startswith(f"{table}.") and one["key"] == last]
    except (FileNotFoundError, RunFailed):
        return ""
    units = {one["unit"] for one in [one for one in known if one["path"].startswith(f"{table}.{kind}.")] or known}
    return units.pop() if len(units) == 1 else ""
