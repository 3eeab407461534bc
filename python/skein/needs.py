"""What a program needs of this Python and of a run, asked for before anything is done: whatever is missing is told in a sentence.

Only the standard library, so that a Python without numpy can say so.
"""

import sys
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path


class NotResults(Exception):
    """A directory does not hold what was asked of it."""


class Damaged(NotResults):
    """A file of a run cannot be read: the message begins with its path."""


WHATEVER = (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, RuntimeError, SyntaxError, OverflowError)


@contextmanager
def reading(path, errors=WHATEVER):
    """Within it, what a library finds wrong with a file (`errors`) becomes one sentence that names the file."""
    try:
        yield
    except NotResults:
        raise
    except FileNotFoundError:
        raise NotResults(f"{path}: no such file") from None
    except errors as error:
        words = " ".join(str(error).split()) or type(error).__name__
        raise Damaged(f"{path}: cannot be read ({words}); it is damaged, or not a file of Skein") from error


def in_words(main, code=1, code_of_damage=1):
    """Runs a program's `main`; what is not there ends the program with a sentence in place of a traceback."""
    try:
        main()
    except NotResults as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(code_of_damage if isinstance(error, Damaged) else code)


def missing(packages):
    for name in packages:
        try:
            import_module(name)
        except ImportError:
            yield name


def lacks(names):
    """A sentence on packages that this Python does not have."""
    debian = " ".join(f"python3-{name}" for name in names)
    return f"{sys.executable} has no {', '.join(names)}; on Debian 'apt install {debian}', and start with /usr/bin/python3"


def need(*packages):
    """Ends the program unless all of these packages can be imported."""
    names = list(missing(packages))
    if names:
        sys.exit(f"{Path(sys.argv[0]).name}: {lacks(names)}")


def need_files(directory, *patterns):
    """Raises NotResults unless each pattern matches a file of the run's output directory."""
    directory = Path(directory)
    if not directory.is_dir():
        raise NotResults(f"{directory}: no such directory; give the output directory of a run")
    for pattern in patterns:
        if not any(directory.glob(pattern)):
            raise NotResults(f"{directory}: no {pattern}; give the output directory of a run that writes it")


def need_names(directory, what, names, wanted, hint):
    """Raises NotResults unless all wanted names are among those that a run's file has."""
    absent = [name for name in wanted if name not in names]
    if absent:
        raise NotResults(f"{directory}: no {what} {', '.join(absent)}; {hint}")
