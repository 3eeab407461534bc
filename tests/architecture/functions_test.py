#!/usr/bin/env python3
"""No function of src/, include/ and apps/ is longer than 60 lines.

    functions_test.py ROOT
"""
import re
import sys
from pathlib import Path

MOST = 60
NOT_A_FUNCTION = re.compile(r"(if|for|while|switch|catch|else|do|try|namespace|class|struct|enum|union|return|extern)\b")
LAMBDA = re.compile(r"\[[^\[\]]*\]\s*(\([^()]*\))?\s*(mutable\s*)?(->[^{]*)?$")


def without_texts(text):
    """Code whose strings, comments and preprocessor lines are blank, on the same lines."""
    def blank(found):
        return found[0].count("\n") * "\n"
    text = re.sub(r'R"(\w*)\((.*?)\)\1"|/\*.*?\*/|//[^\n]*', blank, text, flags=re.S)
    text = re.sub(r'"(\\.|[^"\\\n])*"|\'(\\.|[^\'\\\n])\'', '""', text)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.M)


def functions(text):
    """(first line, lines, head, heads of the blocks around it) of each."""
    open_heads, head, line, first = [], "", 1, 1
    for c in without_texts(text):
        line += c == "\n"
        if c == "{":
            open_heads.append((" ".join(head.split()), first))
        if c == "}" and open_heads:
            of, begins = open_heads.pop()
            of = re.sub(r"^(?:public|private|protected)\s*:\s*|^template\s*<.*?>\s*(?=\w)", "", of)
            if "(" in of and not NOT_A_FUNCTION.match(of) and not LAMBDA.search(of) and "=" not in of.split("(")[0]:
                yield begins, line - begins + 1, of, [around for around, _ in open_heads]
        if c in "{};":
            head = ""
        elif head or not c.isspace():
            if not head:
                first = line
            head += c


def try_the_rules():
    body = "    ++i;\n"
    found = list(functions("namespace a {\nvoid f(int i) {\n" + 3 * body + "}\nstruct S {\n    int g() const { return 1; }\n};\n}\n"))
    assert [(lines, head) for _, lines, head, _ in found] == [(5, "void f(int i)"), (1, "int g() const")], found
    assert not list(functions("const auto f = [&](int i) {\n" + body + "};\n// void g() {\nconst char* s = \"void h() {\";\n"))


def main():
    root = Path(sys.argv[1])
    try_the_rules()
    count, problems = 0, []
    for folder in ("src", "include", "apps"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".cpp", ".hpp"):
                continue
            for line, lines, head, _ in functions(path.read_text()):
                count += 1
                if lines > MOST:
                    problems.append(f"{path.relative_to(root)}:{line}: {lines} lines, expected at most {MOST}: {head[:80]}")
    print("\n".join(problems) or f"{count} functions have at most {MOST} lines")
    return 1 if problems or count < 1000 else 0


if __name__ == "__main__":
    sys.exit(main())
