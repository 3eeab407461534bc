"""Skein from Python: scenes, runs, results and pictures. docs/python.md is the guide."""

from .needs import NotResults
from .results import Group, Results, Series, open  # noqa: A004  (as skein.open it shadows nothing of the caller's)

__all__ = ["Group", "NotResults", "Results", "Series", "open"]
