"""What a program needs of this Python and of a run, asked for before anything is done: whatever is missing is told in a sentence.

Only the standard library, so that a Python without numpy can say so.
"""

import sys
from importlib import import_module
from pathlib import Path


class NotResults(SystemExit):
    """A directory does not hold what was asked of it. Ends a program with a sentence, unless caught."""


def missing(packages):
    for name in packages:
        try:
            import_module(name)
        except ImportError:
            yield name


def need(*packages):
    """Ends the program unless all of these packages can be imported."""
    names = list(missing(packages))
    if names:
        debian = " ".join(f"python3-{name}" for name in names)
        sys.exit(f"{Path(sys.argv[0]).name}: {sys.executable} has no {', '.join(names)}; on Debian 'apt install {debian}', "
                 "and start with /usr/bin/python3")


def need_files(directory, *patterns):
    """Ends the program unless each pattern matches a file of the run's output directory."""
    directory = Path(directory)
    if not directory.is_dir():
        raise NotResults(f"{directory}: no such directory; give the output directory of a run")
    for pattern in patterns:
        if not any(directory.glob(pattern)):
            raise NotResults(f"{directory}: no {pattern}; give the output directory of a run that writes it")


def need_names(directory, what, names, wanted, hint):
    """Ends the program unless all wanted names are among those that a run's file has."""
    absent = [name for name in wanted if name not in names]
    if absent:
        raise NotResults(f"{directory}: no {what} {', '.join(absent)}; {hint}")
