"""Blocks of code of the pages in docs/."""

import re
import sys


def blocks(page, heading, language):
    """Blocks of a language below a heading, up to the next heading of its rank."""
    text = page.read_text()
    rank = heading.split()[0]
    start = text.index(f"\n{heading}\n")
    end = re.search(rf"^#{{1,{len(rank)}}} ", text[start + len(heading) + 2:], re.M)
    section = text[start: start + len(heading) + 2 + end.start() if end else None]
    found = re.findall(rf"^```{language}\n(.*?)^```$", section, re.M | re.S)
    if not found:
        sys.exit(f"{page}: no block of {language} below '{heading}'")
    return found
