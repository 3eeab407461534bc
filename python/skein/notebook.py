"""HTML in notebooks: tables of names and values. All text is escaped, as titles and names come from files."""

import base64
from html import escape
from pathlib import Path

LARGEST_PICTURE = 2 << 20  # bytes, within a page


def table(title, rows, heading=()):
    """`rows`: lists of cells, the first a heading of its row."""
    head = f"<tr>{''.join(f'<th>{escape(str(cell))}</th>' for cell in heading)}</tr>" if heading else ""
    body = "".join(f"<tr><th style='text-align:left'>{escape(str(first))}</th>{''.join(f'<td>{escape(_words(cell))}</td>' for cell in others)}</tr>" for first, *others in rows)
    return f"<table><caption style='text-align:left'><b>{escape(str(title))}</b></caption>{head}{body}</table>"


def picture(path):
    """An image within the page; empty if there is none or a large one."""
    path = Path(path)
    if not path.is_file() or path.stat().st_size > LARGEST_PICTURE:
        return ""
    return f"<img style='max-width:480px' src='data:image/png;base64,{base64.b64encode(path.read_bytes()).decode()}'>"


def _words(cell):
    return f"{cell:.6g}" if isinstance(cell, float) else "" if cell is None else str(cell)
