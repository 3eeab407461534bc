#!/usr/bin/env python3
"""Holds the subjects of commits to the rules of CONTRIBUTING.md, from one commit on.

    commits_test.py ROOT

A subject has at most 72 characters, begins with the module that it touches and holds one thought. Where there is no history (an
archive, a shallow clone), nothing is tested.
"""
import re
import subprocess
import sys

FIRST = "fde2bc51"  # the last commit before the rule
LONGEST = 72
SKIP = 77


def faults(subject):
    if len(subject) > LONGEST:
        yield f"{len(subject)} characters, more than {LONGEST}"
    if not re.match(r"[a-z_.]+(, [a-z_.]+)*: \S", subject):
        yield "does not begin with a module and a colon"
    if ";" in subject:
        yield "holds two thoughts, joined by ';'"


def main():
    assert list(faults("io: single frames as virtual datasets")) == []
    assert len(list(faults("Frames; and " + 70 * "x"))) == 3
    log = subprocess.run(["git", "-C", sys.argv[1], "log", "--no-merges", "--format=%h %s", f"{FIRST}..HEAD"], capture_output=True, text=True)
    if log.returncode:
        print("no history here")
        return SKIP
    problems = [f"{line}: {fault}" for line in log.stdout.splitlines() for fault in faults(line.split(" ", 1)[1])]
    print("\n".join(problems) or f"{len(log.stdout.splitlines())} subjects")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
