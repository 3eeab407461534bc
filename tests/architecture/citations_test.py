#!/usr/bin/env python3
"""Every equation that the code cites has its number in docs/theory.md, every file that code or pages refer to is there, and every
study that a page cites has its entry in docs/references.md, and every entry is cited.

    citations_test.py ROOT
"""
import re
import sys
from pathlib import Path

FOLDERS = ("src", "apps", "tests", "bench", "cmake", "docs")
REFERENCES = "docs/references.md"
KINDS = (".cpp", ".hpp", ".py", ".cmake", ".txt", ".md", ".toml")


def cited_numbers(text):
    """Numbers in "theory.md (8)-(15), (34)": ranges are filled."""
    for citation in re.findall(r"theory\.md((?:\s*[,-]?\s*\(\d+\)(?:-\(\d+\))?)+)", text):
        for first, last in re.findall(r"\((\d+)\)(?:-\((\d+)\))?", citation):
            yield from range(int(first), int(last or first) + 1)


def anchors(text):
    """Names that GitHub gives to the headings of a page, and those that the page gives to single places."""
    yield from re.findall(r'<a id="([^"]*)">', text)
    for heading in re.findall(r"^#+ (.*)$", text, re.M):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def cited_keys(text):
    """Keys of docs/references.md in links, from any page; within that page from one entry to another."""
    return re.findall(r"\]\((?:[./\w]*references\.md)?#(\w+)\)", text)


def check_references(pages):
    """Problems of docs/references.md: an entry is `<a id="key"></a>**key.** text`."""
    page = pages.get(REFERENCES, "")
    entries = re.findall(r'^\* <a id="([^"]*)"></a>\*\*([^*]*)\.\*\* \S', page, re.M)
    keys = [key for key, _ in entries]
    problems = [f"{REFERENCES}: the entry of {key} calls itself {name}" for key, name in entries if key != name]
    problems += [f"{REFERENCES}: {key} has two entries" for key in sorted(set(keys)) if keys.count(key) > 1]
    if len(keys) != page.count("<a id="):
        problems.append(f"{REFERENCES}: {page.count('<a id=')} places have a name, {len(keys)} of them are entries")
    cited = set()
    for path, text in pages.items():
        found = set(re.findall(r"references\.md#(\w+)", text)) | (set(cited_keys(text)) if path == REFERENCES else set())
        problems += [f"{path}: {REFERENCES} has no entry {key}" for key in sorted(found - set(keys))]
        cited |= found
    return problems + [f"{REFERENCES}: no page cites {key}" for key in keys if key not in cited]


def check(root, files, pages):
    """`files`: {path: text} of all; `pages`: {path: text} of all pages for readers."""
    problems = []
    tags = [int(tag) for tag in re.findall(r"\\tag\{(\d+)\}", pages["docs/theory.md"])]
    if tags != list(range(1, len(tags) + 1)):
        problems.append(f"docs/theory.md: equations are numbered {tags}")
    for path, text in files.items():
        for number in cited_numbers(text):
            if number not in tags:
                problems.append(f"{path}: theory.md has no equation ({number})")
        for page in re.findall(r"\bdocs/(\w+\.md)\b", text):
            if f"docs/{page}" not in pages:
                problems.append(f"{path}: there is no docs/{page}")
    for path, text in pages.items():
        for page, anchor in re.findall(r"\]\(((?!https?:)[^)#]*)(?:#([^)]*))?\)", text):
            target = (root / path).parent / page if page else root / path
            name = str(target.resolve().relative_to(root.resolve())) if target.exists() else None
            if not target.exists():
                problems.append(f"{path}: link to {page}, which is not there")
            elif anchor and name in pages and anchor not in anchors(pages[name]):
                problems.append(f"{path}: link to {page}#{anchor}, which is not a heading")
    return problems


def try_the_rules(root):
    theory = {"docs/theory.md": "# A b\n\\tag{1}\n\\tag{2}\n[x](#a-b)"}
    where = "theory" ".md"  # in two, so that this file cites nothing
    assert list(cited_numbers(f"{where} (1)-(3), (7) and {where} (9)")) == [1, 2, 3, 7, 9]
    assert not check(root, {"a.cpp": f"{where} (1)-(2)"}, theory)
    assert check(root, {"a.cpp": f"{where} (1)-(3)"}, theory)
    assert check(root, {"a.cpp": "docs" "/none.md"}, theory)
    assert check(root, {}, {"docs/theory.md": "\\tag{1}\\tag{3}"})
    assert check(root, {}, theory | {"docs/" "b.md": "[x](none.md)"})
    assert check(root, {}, theory | {"docs/architecture.md": "[x](theory.md#c)"})
    entry = {REFERENCES: '* <a id="a1"></a>**a1.** Text.\n'}
    citing = {"README.md": "[A](docs/references.md#a1)"}
    assert not check_references(entry | citing)
    assert check_references(entry)
    assert check_references(entry | {"README.md": "[A](docs/references.md#a1) [B](docs/references.md#b1)"})
    assert check_references({REFERENCES: 2 * entry[REFERENCES]} | citing)
    assert check_references({REFERENCES: entry[REFERENCES].replace("**a1", "**a2")} | citing)


def main():
    root = Path(sys.argv[1])
    try_the_rules(root)
    texts = {str(path.relative_to(root)): path.read_text(errors="replace") for folder in FOLDERS for path in (root / folder).rglob("*")
             if path.suffix in KINDS}
    pages = {path: text for path, text in texts.items() if path.endswith(".md")}
    pages |= {path.name: path.read_text() for path in root.glob("*.md")}
    problems = check(root, texts | pages, pages) + check_references(pages)
    cited = sorted({number for text in texts.values() for number in cited_numbers(text)})
    print("\n".join(problems) or f"{len(cited)} equations are cited, all are there")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
