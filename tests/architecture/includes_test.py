#!/usr/bin/env python3
"""Holds every #include against the table of modules in docs/architecture.md, and libraries against the modules that own them. From
the public headers in include/skein no private one is reached.

    includes_test.py ROOT

The rules are first tried on a forged tree that breaks each of them, so that a test which finds nothing has looked.
"""
import re
import sys
from pathlib import Path

# Header -> modules of src/ that may include it.
LIBRARIES = {
    r"mpi\.h": {"parallel", "io"},
    r"hdf5\.h": {"io"},
    r"zlib\.h": {"io"},
    r"fftw3\.h": {"fluid"},
    r"petsc.*": {"fluid", "equilibrium", "parallel"},
    r"(Eigen|Spectra)/.*": {"equilibrium", "implicit", "studies"},
    r"tbb/.*": {"parallel"},
    r"toml.*": {"scene"},
    r"tao/.*": {"formula"},
    r"CLI/.*": set(),
}
FRONT = {"load.hpp": "loads", "run.hpp": "simulation", "skein.h": "simulation"}  # public headers that stand for a module
ONCE = (r"toml.*", r"tao/.*")  # cost seconds to compile: one source each in all


def read_table(text):
    """{module: layer} from the rows "| layer | `module` | ... |"."""
    return {module: int(layer) for layer, module in re.findall(r"^\|\s*(\d+)\s*\|\s*`(\w+)`\s*\|", text, re.M)}


def includes(text):
    """(line number, header, quoted) of every #include."""
    for number, line in enumerate(text.splitlines(), 1):
        if found := re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line):
            yield number, found[2], found[1] == '"'


def may_include(table, module, other):
    return module == other or table[other] < table[module]


def public_module(name):
    """That of a header below include/skein."""
    return FRONT.get(name, name.split("/")[0])


def module_of(path):
    """That of a source below the root; None in apps/."""
    if path.startswith("include/skein/"):
        return public_module(path.removeprefix("include/skein/"))
    parts = Path(path).parts
    return parts[1] if parts[0] == "src" else None


def check_sources(table, sources):
    """`sources`: {path below the root: text} of src/, include/ and apps/."""
    problems, once = [], {library: [] for library in ONCE}
    for path, text in sorted(sources.items()):
        module = module_of(path)
        if module and module not in table:
            problems.append(f"{path}: module '{module}' has no row in the table")
            continue
        for line, header, quoted in includes(text):
            where = f"{path}:{line}"
            if not header.startswith("skein/") and path.startswith("include/") and quoted:
                problems.append(f"{where}: a public header includes the private \"{header}\"")
            elif quoted and "/" in header:
                other = public_module(header.removeprefix("skein/")) if header.startswith("skein/") else header.split("/")[0]
                if other not in table:
                    problems.append(f"{where}: \"{header}\" belongs to no module of the table")
                elif module and not may_include(table, module, other):
                    problems.append(f"{where}: '{module}' may not include '{other}' (\"{header}\")")
            elif quoted and module:
                problems.append(f"{where}: \"{header}\" does not name its module")
            elif not quoted:
                for library, owners in LIBRARIES.items():
                    if module and re.fullmatch(library, header) and module not in owners:
                        problems.append(f"{where}: '{module}' may not include <{header}>")
                for library, places in once.items():
                    if re.fullmatch(library, header):
                        places.append(where)
                        if not path.endswith(".cpp"):
                            problems.append(f"{where}: <{header}> in a header")
    problems += [f"<{library}> is included more than once: " + ", ".join(places) for library, places in once.items() if len(places) > 1]
    return problems


def check_links(table, cmake):
    """`cmake`: {module: text of its CMakeLists.txt}; links must stay within the table too."""
    problems = []
    for module, text in sorted(cmake.items()):
        for other in set(re.findall(r"\bskein_(\w+)\b(?!\()", text)) - {"flags", module}:  # not functions
            if module in table and (other not in table or not may_include(table, module, other)):
                problems.append(f"src/{module}/CMakeLists.txt: '{module}' may not link to '{other}'")
    return problems


def try_the_rules():
    table = {"low": 0, "parallel": 1, "high": 1, "scene": 2}
    broken = {
        "src/low/a.cpp": '#include "high/b.hpp"\n',
        "src/high/b.cpp": '#include "low/a.hpp"\n#include "parallel/c.hpp"\n',
        "src/high/c.cpp": "#include <mpi.h>\n",
        "src/high/d.cpp": "#include <CLI/CLI.hpp>\n",
        "src/high/e.cpp": '  #  include "unknown/x.hpp"\n',
        "src/high/f.cpp": '#include "f.hpp"\n',
        "src/other/g.cpp": "",
        "src/scene/h.cpp": "#include <toml++/toml.h>\n",
        "src/scene/i.hpp": "#include <toml++/toml.h>\n",
        "include/skein/low/j.hpp": '#include "low/k.hpp"\n#include "skein/low/l.hpp"\n#include <vector>\n',
        "include/skein/low/m.hpp": '#include "skein/scene/n.hpp"\n',
        "include/skein/low/o.hpp": "#include <mpi.h>\n",
        "src/low/p.cpp": '#include "skein/low/j.hpp"\n#include "skein/high/q.hpp"\n',
        "src/high/r.cpp": "#include <tao/pegtl.hpp>\n",
        "apps/main.cpp": '#include <CLI/CLI.hpp>\n#include "high/b.hpp"\n#include "own.hpp"\n',
    }
    expected = ["a.cpp:1: 'low' may not include 'high'", "p.cpp:2: 'low' may not include 'high'", "b.cpp:2: 'high' may not include 'parallel'",
                "may not include 'scene'", "c.cpp:1: 'high' may not include <mpi.h>", "o.hpp:1: 'low' may not include <mpi.h>",
                "may not include <CLI/CLI.hpp>", "may not include <tao/pegtl.hpp>", "belongs to no module", "does not name its module", "'other' has no row", "in a header",
                "more than once", "a public header includes the private"]
    found = check_sources(table, broken)
    for text in expected:
        assert sum(text in problem for problem in found) == 1, f"the rule '{text}' does not work: {found}"
    assert len(found) == len(expected), found
    assert read_table("| layer | module |\n|---|---|\n| 3 | `a` | ... |\n") == {"a": 3}
    assert check_links(table, {"low": "skein_module(low DEPENDS skein_high)"}) and not check_links(table, {"high": "DEPENDS skein_low"})


def main():
    try_the_rules()
    root = Path(sys.argv[1])
    table = read_table((root / "docs/architecture.md").read_text())
    sources = {str(path.relative_to(root)): path.read_text() for folder in ("src", "include", "apps") for path in (root / folder).rglob("*")
               if path.suffix in (".cpp", ".hpp")}
    cmake = {path.parent.name: path.read_text() for path in (root / "src").glob("*/CMakeLists.txt")}
    problems = check_sources(table, sources) + check_links(table, cmake)
    problems += [f"table: module '{module}' is not in src/" for module in table if not (root / "src" / module).is_dir()]
    print("\n".join(problems) or f"{len(sources)} sources of {len(table)} modules keep to docs/architecture.md")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
