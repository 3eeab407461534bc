#!/usr/bin/env python3
"""The scene and the plan name no physics, in no form, and what docs/architecture.md says of places in the code is there.

    house_test.py ROOT

The rules are first tried on forged sources that break each of them.
"""
import re
import sys
from pathlib import Path

NEUTRAL = ("src/scene", "src/plan")  # know physics through the list in physics/tables.hpp alone
WORDS = ("contacts?", "walls?", "servos?", "joints?", "fluids?", r"immers\w+", "obstacles?", r"relax\w*", r"audit\w*", "gravity",
         "muscles?", "magnetic")
PHYSICS = re.compile("|".join(rf"(?<![A-Za-z]){word}(?![a-z])|{word[0].upper()}{word[1:]}(?![a-z])" for word in WORDS))
OTHER_SENSES = re.compile(r"wall (time|clock)|checkpoint_wall|frames_wall", re.I)


def named_physics(text):
    """(line number, word) of each physics that a source names."""
    for number, line in enumerate(text.splitlines(), 1):
        for found in PHYSICS.finditer(OTHER_SENSES.sub("", line)):
            yield number, found[0]


def places(page):
    """(thing, file, function, file of the call, call) of the table of places."""
    row = r"^\| ([^|]+) \| `([^`]+)` \| `([^`]+)` \| `([^`]+)` \| `([^`]+)` \|$"
    return re.findall(row, page, re.M)


def check_places(page, read):
    """`read`: path -> text, or None."""
    problems = []
    for thing, file, function, caller, call in places(page):
        for path, words in ((file, function), (caller, call)):
            text = read(f"src/{path}")
            if text is None:
                problems.append(f"docs/architecture.md: {thing}: there is no src/{path}")
            elif words not in text:
                problems.append(f"docs/architecture.md: {thing}: src/{path} does not hold '{words}'")
    return problems


def try_the_rules():
    assert [word for _, word in named_physics('f("contact"); // walls\nFluidPlan p; is_relaxed; wall time; boundaries')] == ["contact", "walls", "Fluid", "relaxed"]
    page = "| a force | `a.cpp` | `push(` | `b.cpp` | `a.push(` |\n"
    sources = {"src/a.cpp": "void push(", "src/b.cpp": "a.push();"}
    assert not check_places(page, sources.get)
    assert check_places(page.replace("a.cpp", "c.cpp"), sources.get)
    assert check_places(page.replace("`push(`", "`pull(`"), sources.get)
    assert check_places(page.replace("a.push(", "a.pull("), sources.get)


def main():
    root = Path(sys.argv[1])
    try_the_rules()
    problems = []
    for folder in NEUTRAL:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".cpp", ".hpp"):
                problems += [f"{path.relative_to(root)}:{line}: names the physics '{word}'" for line, word in named_physics(path.read_text())]
    page = (root / "docs/architecture.md").read_text()
    things = len(places(page))
    if things < 6:
        problems.append(f"docs/architecture.md: {things} rows of places, expected 6 at least")
    problems += check_places(page, lambda path: (root / path).read_text() if (root / path).is_file() else None)
    print("\n".join(problems) or f"{things} places are where docs/architecture.md says")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
