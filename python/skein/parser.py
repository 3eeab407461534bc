"""Words of a command whose errors have the form of the program's, and name the option that was probably meant."""

import argparse
from difflib import get_close_matches


class Parser(argparse.ArgumentParser):
    """Of `skein NAME`; `takes`: what its words without a dash are."""

    def __init__(self, *, takes, **others):
        super().__init__(**others)
        self._takes = takes

    def parse_args(self, words=None):
        given, others = self.parse_known_args(words)
        if others:
            self.error(self._unknown(others[0]))
        return given

    def _unknown(self, word):
        command = self.prog.split()[-1]
        if not word.startswith("-"):
            return f"'{word}' is one word too many; {command} takes {self._takes}"
        name = word.split("=")[0]
        near = get_close_matches(name, [option for action in self._actions for option in action.option_strings], 1)
        return f"{command} has no option '{name}'; " + (f"did you mean '{near[0]}'?" if near else f"{self.prog} --help lists all")

    def error(self, message):
        self.exit(2, f"error: {message}\n")
