"""Places of docs/troubleshooting.md that messages end with are on the page, in the row of the message, and the program prints such messages.

  troubleshooting_test.py ROOT
"""

import pathlib
import re
import sys

from language_test import printed

PAGE, TABLE = "docs/troubleshooting.md", "src/core/troubleshooting.cpp"
ENTRY = re.compile(r'^ +\{"((?:[^"\\]|\\.)*)", "([a-z-]+)"\},$', re.MULTILINE)
ROW = re.compile(r'^\| <a id="([a-z-]+)"></a>(.*?) \| ', re.MULTILINE)


def problems(table, page, literals):
    """`literals`: texts of the sources, escaped as in the table. Placeholders of formats match whatever stands there."""
    entries, rows = ENTRY.findall(table), dict(ROW.findall(page))
    if len(entries) < 10 or len(entries) != table.count('", "'):
        yield f"{TABLE}: {len(entries)} entries of {table.count(chr(34) + ', ' + chr(34))} are read"
    for anchor in [*rows, *(anchor for _, anchor in entries)]:
        if page.count(f'<a id="{anchor}"></a>') != 1:
            yield f"{PAGE}: #{anchor} is there {page.count(anchor)} times"
    for anchor in rows.keys() - {anchor for _, anchor in entries}:
        yield f"{PAGE}: no message leads to #{anchor}"
    for part, anchor in entries:
        words = part.replace("\\", "").strip(" ':;,()[\"")
        if words not in rows.get(anchor, ""):
            yield f"{PAGE}: the row #{anchor} has no message with '{words}'"
        if not any(part in text or part in re.sub(r"\{\}", "key", text, count=1) or part in re.sub(r"\{\}", "table", text, count=1) for text in literals):
            yield f"{TABLE}: no message of the program has '{part}'"


def test_itself():
    table = "".join(f'    {{"part {i} ", "anchor-{chr(97 + i)}"}},\n' for i in range(10))
    page = "".join(f'| <a id="anchor-{chr(97 + i)}"></a>`part {i}` | cause |\n' for i in range(10))
    literals = [f"a part {i} of it" for i in range(10)]
    assert not list(problems(table, page, literals))
    for wrong in ((table, page.replace("anchor-b", "anchor-z"), literals), (table, page.replace("part 3", "part"), literals), (table, page, literals[1:])):
        assert list(problems(*wrong)), wrong


if __name__ == "__main__":
    test_itself()
    root = pathlib.Path(sys.argv[1])
    table = (root / TABLE).read_text()
    texts = [text for place, text in printed(root) if not place.startswith(TABLE)]
    found = list(problems(table, (root / PAGE).read_text(), texts))
    print("\n".join(found) or f"{len(ENTRY.findall(table))} parts of messages have their places on the page")
    sys.exit(1 if found else 0)
