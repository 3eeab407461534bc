"""Skein from Python: scenes, runs, results and pictures. docs/python.md is the guide."""

from importlib import import_module

# Where each name lives: imported when it is first used, so that a Python that lacks a package can say so.
_HOMES = {"Group": "results", "Results": "results", "Series": "results", "open": "results",
          "NotResults": "needs", "Damaged": "needs",
          "draw": "picture.draw", "movie": "picture.draw", "Pictures": "picture.draw",
          "run": "program", "plan": "program", "RunFailed": "program",
          "Scene": "scene", "swc": "centrelines", "read_centrelines": "centrelines", "SwcTree": "centrelines", "persistence_length": "persistence", "Simulation": "simulation",
          "equilibrium": "equilibria", "modes": "equilibria", "path": "equilibria", "fit": "fits", "gradient": "fits",
          "sweep": "sweeps", "page": "picture.page", "state": "picture.state"}

__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 'skein' has no attribute '{name}'")
    try:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    except ModuleNotFoundError as error:
        if error.name.partition(".")[0] == __name__:
            raise
        lacks = import_module(".needs", __name__).lacks
        raise ModuleNotFoundError(lacks([error.name]), name=error.name) from None


def __dir__():
    return sorted(__all__)
