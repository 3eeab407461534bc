#!/usr/bin/env python3
"""Functions, types and constants of one file, in an unnamed namespace or static, have names that no other file of their target uses so.

Sources of a target may be compiled together (SKEIN_UNITY): two such functions with other arguments would become overloads, and a call
might find the wrong one without a word.

    unity_test.py ROOT
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

from functions_test import functions

TYPE = re.compile(r"^(?:class|struct|enum(?: class)?) (\w+)(?: final)?(?: :| \{)", re.MULTILINE)
CONSTANTS = re.compile(r"^(?:static |inline )?(?:constexpr|const) [^(;\n]*?=.*?;", re.MULTILINE | re.DOTALL)
CONSTANT = re.compile(r"(\w+)(?:\[\w*\])? =(?!=)")
NAME = re.compile(r"(operator\s*[^\s\w(]+|\w+)\s*\(")


def file_functions(text):
    """Names of functions that only their file sees."""
    for _, _, head, around in functions(text):
        name = NAME.search(head)
        qualified = name and "::" in head[: name.end()].split()[-1]
        of_file = "namespace" in around or head.startswith("static ")
        if name and not qualified and of_file and all(one.startswith("namespace") for one in around):
            yield name[1]


def file_names(text):
    """Names of types and constants that begin a line of a source."""
    return [*TYPE.findall(text), *(name for line in CONSTANTS.findall(text) for name in CONSTANT.findall(line))]


def try_the_rules():
    text = "namespace a {\nnamespace {\nint f(int x) { if (x) { g(); } return 1; }\nstruct S { int h() { return 1; } };\n}\nint k() {}\nint S::m() {}\nstatic int n() {}\n}\n"
    assert list(file_functions(text)) == ["f", "n"], list(file_functions(text))
    text = "constexpr double a = 1, e[] = {2};\nconst std::string b =\n    1;\nclass C {\n    static constexpr int d = 1;\n};\nstruct E;\nstruct F final : G {};\n"
    assert file_names(text) == ["C", "F", "a", "e", "b"], file_names(text)


def main():
    try_the_rules()
    root = Path(sys.argv[1])
    targets = [*(root / "src").iterdir(), root / "apps/skein"]
    count, problems = 0, []
    for target in (folder for folder in targets if folder.is_dir()):
        files = defaultdict(set)
        for path in sorted(target.rglob("*.cpp")):
            for name in file_functions(path.read_text()):
                files[f"{name}()"].add(str(path.relative_to(target)))
                count += 1
            for name in file_names(path.read_text()):
                files[name].add(str(path.relative_to(target)))
        problems += [f"{target.relative_to(root)}: {name} is a name of its file in {', '.join(sorted(paths))}"
                     for name, paths in sorted(files.items()) if len(paths) > 1]
    assert count > 300, count
    print("\n".join(problems) or f"{count} functions of files, and types and constants beside them")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
