#!/usr/bin/env python3
"""Holds comments and lines of src/ and include/ to the rules of CONTRIBUTING.md.

    comments_test.py ROOT

Comments begin with a noun or a verb of the field: fewer than one in a hundred begins with Of, What, Whether, Where or Those. A line
is at most 120 characters long, but for texts of several lines.
"""
import re
import sys
from pathlib import Path

AVOIDED = re.compile(r"(Of|What|Whether|Where|Those)\b")
MOST = 0.01
LONGEST_LINE = 120


def openings(text):
    """First words of comments: of whole lines that begin one, and of trailing ones."""
    before = ""
    for line in text.splitlines():
        found = re.match(r"\s*//+<?\s*(\S.*)", line)
        if found and not re.match(r"\s*//", before):
            yield found[1]
        elif not found and (trailing := re.search(r"\s//+<?\s*(\S[^\"]*)$", line)):
            yield trailing[1]
        before = line


def without_texts(text):
    """Raw strings by as many empty lines."""
    return re.sub(r'R"\((.*?)\)"', lambda raw: raw[1].count("\n") * "\n", text, flags=re.S)


def avoided_share(texts):
    all_of_them = [opening for text in texts for opening in openings(text)]
    avoided = [opening for opening in all_of_them if AVOIDED.match(opening)]
    return len(avoided) / max(1, len(all_of_them)), avoided


def try_the_rules():
    assert list(openings("// Of a rod\n// What follows\nint a; // Whether so\nint b; ///< length, m\n")) == ["Of a rod", "Whether so", "length, m"]
    assert without_texts('a\nR"(b\nc)"\nd') == "a\n\n\nd"
    assert avoided_share(["// Of a rod\nint a; ///< length\n"])[0] == 0.5


def main():
    try_the_rules()
    root = Path(sys.argv[1])
    texts = {path: path.read_text() for folder in ("src", "include") for path in sorted((root / folder).rglob("*.[ch]pp"))}
    assert len(texts) > 300, len(texts)
    share, avoided = avoided_share(texts.values())
    problems = [f"{100 * share:.2f} % of comments begin with Of, What, Whether, Where or Those:"] + avoided[:20] if share >= MOST else []
    for path, text in texts.items():
        problems += [f"{path.relative_to(root)}:{number}: {len(line)} characters"
                     for number, line in enumerate(without_texts(text).splitlines(), 1) if len(line) > LONGEST_LINE]
    print("\n".join(problems) or f"{len(avoided)} of the comments, {100 * share:.2f} %, begin with a word to avoid")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
