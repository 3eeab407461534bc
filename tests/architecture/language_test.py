"""Pages read like those of a technical writer: docs/style.md lists the turns to avoid, and this test counts them. It also measures
sentences, and the phrases in cells of tables, over all pages and on each.

  language_test.py ROOT [PAGE...]    with pages: prints every hit and every long sentence of these pages
"""

import pathlib
import re
import sys

TURN = re.compile(r"^\| [^|]+ \| `([^`]+)` \|", re.MULTILINE)
MOST_PER_1000_WORDS = 0.1
LONGEST_SENTENCE = 35
LONGEST_MEAN = 20
WORD = re.compile(r"[^\W\d_](?:[\w'’-]*\w)?")
TOKEN = re.compile(r"\S*\w\S*")


def turns(style):
    """The regular expressions in the table of docs/style.md."""
    return [re.compile(expression.replace(r"\|", "|"), re.MULTILINE) for expression in TURN.findall(style)]


def pages(root):
    found = [page for pattern in ("*.md", "apps/**/*.md", "docs/*.md", "tests/**/*.md", "bench/README.md") for page in root.glob(pattern)]
    return sorted(str(page.relative_to(root)) for page in found if page.name != "style.md")


def prose(text):
    """A page without code, formulae, targets of links and addresses; lines keep their numbers."""
    blank = lambda match: "\n" * match.group().count("\n")
    text = re.sub(r"```.*?```", blank, text, flags=re.DOTALL)
    text = re.sub(r"\$\$.*?\$\$", blank, text, flags=re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`[^`\n]*`", "Code", text)
    text = re.sub(r"\$[^$\n]*\$", "x", text)
    return re.sub(r"https?://\S+", "address", text)


def sentences(text):
    """(line, sentence) of paragraphs and list items. Rows of tables and headings are not sentences: phrases() has the rows."""
    found, block, first = [], [], 1

    def close():
        start = first
        joined = " ".join(block)
        for sentence in re.split(r"(?<=[.!?])[)\"*]*\s+(?=[A-Z*(\"`x])", joined):
            if WORD.search(sentence):
                found.append((start, sentence.strip()))
        block.clear()

    for number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if not bare or bare.startswith(("|", "#", "<", "---")):
            close()
            continue
        if re.match(r"([-*]|\d+\.)\s", bare):
            close()
            bare = re.sub(r"^([-*]|\d+\.)\s+", "", bare)
        if not block:
            first = number
        block.append(bare)
    close()
    return found


def phrases(text):
    """(line, phrase) of cells of tables in a page. Entries are lists, so a semicolon or a colon ends a phrase; a link counts as one word."""
    for number, line in enumerate(prose(re.sub(r"!?\[[^\]\n]*\]\([^)\n]*\)", "Link", text)).splitlines(), 1):
        bare = line.strip()
        if bare.startswith("|") and not re.fullmatch(r"[|: -]+", bare):
            for cell in re.split(r"(?<!\\)\|", bare.strip("|")):
                yield from ((number, phrase) for phrase in re.split(r"[.;:] ", cell) if WORD.search(phrase))


def words(text):
    return len(WORD.findall(text))


def length(sentence):
    """Words and numbers of a sentence; a formula or a piece of code counts as one."""
    return len(TOKEN.findall(sentence))


STRING = re.compile(r'"((?:[^"\\\n]|\\.)*)"')


def printed(root):
    """(place, text) of sentences in literals of the program and of the Python package, which they print."""
    for path in sorted([*root.glob("src/**/*.[ch]pp"), *root.glob("apps/skein/*.[ch]pp"), *root.glob("python/skein/**/*.py")]):
        text = path.read_text()
        # Docstrings are not printed; literals that follow each other are one text.
        text = re.sub(r'""".*?"""', lambda match: "\n" * match.group().count("\n"), text, flags=re.DOTALL) if path.suffix == ".py" else re.sub(r'"\s*\n\s*"', "", text)
        for raw in re.finditer(r'R"(\w*)\((.*?)\)\1"', text, flags=re.DOTALL):
            first = text.count("\n", 0, raw.start()) + 1
            yield from ((f"{path.relative_to(root)}:{number}", line) for number, line in enumerate(raw[2].splitlines(), first))
        for number, line in enumerate(text.splitlines(), 1):
            if not re.match(r"\s*(//|#)", line):
                yield from ((f"{path.relative_to(root)}:{number}", literal) for literal in STRING.findall(line) if " " in literal)


def report(root, names, expressions):
    for name in names:
        text = prose((root / name).read_text())
        for number, line in enumerate(text.splitlines(), 1):
            for expression in expressions:
                for match in expression.finditer(line):
                    print(f"{name}:{number}: '{match.group().strip()}'")
        for number, sentence in [*sentences(text), *phrases((root / name).read_text())]:
            if length(sentence) > LONGEST_SENTENCE:
                print(f"{name}:{number}: {length(sentence)} words: {sentence[:100]}...")
        counts = [length(sentence) for _, sentence in sentences(text)]
        print(f"{name}: {words(text)} words, {len(counts)} sentences of {sum(counts) / max(len(counts), 1):.1f} words on average")


def check(root, expressions):
    texts = {name: prose((root / name).read_text()) for name in pages(root)}
    total = sum(map(words, texts.values()))
    problems = []
    for expression in expressions:
        hits = [f"{name}: '{m.group().strip()}'" for name, text in texts.items() for m in expression.finditer(text)]
        if 1000 * len(hits) / total >= MOST_PER_1000_WORDS:
            problems.append(f"{len(hits)} hits in {total} words of {expression.pattern}: {hits[:5]}")
    literals = list(printed(root))
    problems += [f"{place}: '{m.group().strip()}' in '{text[:100]}'" for place, text in literals for expression in expressions for m in expression.finditer(text)]
    lengths = []
    for name, text in texts.items():
        problems += [f"{name}:{number}: {length(s)} words: {s[:80]}..." for number, s in [*sentences(text), *phrases((root / name).read_text())] if length(s) > LONGEST_SENTENCE]
        of_page = [length(sentence) for _, sentence in sentences(text)]
        if of_page and sum(of_page) > LONGEST_MEAN * len(of_page):
            problems.append(f"{name}: sentences have {sum(of_page) / len(of_page):.1f} words on average")
        lengths += of_page
    mean = sum(lengths) / len(lengths)
    print("\n".join(problems) or f"{total} words, {len(lengths)} sentences of {mean:.1f} words on average; {len(literals)} printed texts")
    return 1 if problems else 0


def test_itself():
    assert [s for _, s in sentences(prose("One thing. Two `a.b` things.\n\n- a list\n- of two\n\n| a. B |\n"))] == [
        "One thing.", "Two Code things.", "a list", "of two"]
    assert words("two words, $x$ and 3.5 more") == 5 and length("two words, $x$ and 3.5 more - twice") == 7
    assert [p.strip() for _, p in phrases("| a; b. `c` |\n|---|\n| [d e](f) |\n")] == ["a", "b", "Code", "Link"]
    assert turns("| odd | `\\b(?:a\\|b) of\\b` | plain |")[0].search("what is a of it")


if __name__ == "__main__":
    test_itself()
    here = pathlib.Path(sys.argv[1])
    listed = turns((here / "docs/style.md").read_text())
    assert listed, "docs/style.md lists no expressions"
    if len(sys.argv) > 2:
        report(here, sys.argv[2:], listed)
    else:
        sys.exit(check(here, listed))
