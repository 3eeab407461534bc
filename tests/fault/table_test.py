"""table_test.py ROOT: every row of docs/faults.md names tests that are there, and every test of faults has a row."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
tests = root / "tests"
page = (root / "docs/faults.md").read_text()


def named(cell):
    """{(file, case)} of `driver/restart_test.py` test_walltime, test_limits; the case is empty where the whole file is meant."""
    for file, cases in re.findall(r"`([\w/.]+)`((?:[ ,]+(?:test_)?\w+\b(?!/))*)", cell):
        words = re.findall(r"\w+", cases)
        yield from ((file, case) for case in words or [""])


rows = re.findall(r"^\| (\d+) \| (.+?) \| (.+?) \| (.+?) \|$", page, re.M)
problems = [] if [int(row[0]) for row in rows] == list(range(1, 37)) else [f"rows {[row[0] for row in rows]}"]
seen = set()
for number, _, _, cell in rows:
    found = list(named(cell))
    if not found:
        problems.append(f"row {number} names no test")
    for file, case in found:
        path = tests / file if (tests / file).exists() else root / file
        if not path.is_file():
            problems.append(f"row {number}: there is no {file}")
        elif case and not re.search(rf"\b{case}\b", path.read_text()):
            problems.append(f"row {number}: {file} has no {case}")
        seen.add((file, case))
for path in (tests / "fault").glob("*_test.py"):
    for case in re.findall(r"^    def (test_\w+)", path.read_text(), re.M):
        if (f"fault/{path.name}", case) not in seen and (f"fault/{path.name}", "") not in seen:
            problems.append(f"{path.name}: {case} has no row")
print("\n".join(problems) or f"{len(rows)} rows, {len(seen)} tests")
sys.exit(bool(problems))
