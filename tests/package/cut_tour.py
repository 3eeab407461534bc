#!/usr/bin/env python3
"""Cuts the load of docs/tour.md out of the page: its file, and the list of loads with the line that the page tells to write.

    cut_tour.py ROOT OUT     writes OUT/loads/wind.hpp and OUT/loads/load_list.hpp
"""
import re
import sys
from pathlib import Path

from pages import blocks

root, out = Path(sys.argv[1]), Path(sys.argv[2]) / "loads"
load, line = blocks(root / "docs/tour.md", "## 8 A new load", "cpp")
present = (root / "src/loads/load_list.hpp").read_text()
using = re.search(r"using LoadList =\s.*?;", present, re.S)[0]
names = lambda text: re.findall(r"\w+", text.split("<", 1)[1])
if names(line) != names(using) + ["Wind"]:
    sys.exit(f"docs/tour.md: the list of loads is not that of src/loads/load_list.hpp and Wind:\n{line}\n{using}")
include = present.index("\n", present.rindex("#include")) + 1
out.mkdir(parents=True, exist_ok=True)
(out / "wind.hpp").write_text(load)
(out / "load_list.hpp").write_text(present[:include] + '#include "loads/wind.hpp"\n' + present[include:].replace(using, line.strip()))
