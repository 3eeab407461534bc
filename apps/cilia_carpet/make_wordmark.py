#!/usr/bin/env python3
"""Draws wordmark.pbm, the mask of farm_111797.toml: SKEIN in strokes with round ends, exactly 111 797 pixels of ink.

A letter is a set of polylines, scaled along x and y so that the word fills the grid; a pixel is ink where it lies within half
a stroke of one of them. The stroke is the thinnest that gives enough ink; what is then too much goes from the outline, in scan
order. Takes 10 s.
"""

import math
from pathlib import Path

CILIA = 111_797
WIDTH, HEIGHT = 1050, 196  # pixels
MARGIN = 4
GAP = 22  # between letters


def arc(x, y, radius, begin, end):
    """Points of an arc, angles in degrees from +x towards +y."""
    steps = 16
    angles = [math.radians(begin + (end - begin) * i / steps) for i in range(steps + 1)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]


# Letter: width and strokes, between centres of strokes; y upwards from 0 to 1.
LETTERS = {
    "S": (0.95, [[(0.95, 1), *arc(0.25, 0.75, 0.25, 90, 270), *arc(0.70, 0.25, 0.25, 90, -90), (0, 0)]]),
    "K": (0.95, [[(0, 0), (0, 1)], [(0.92, 1), (0.12, 0.5), (0.95, 0)]]),
    "E": (0.85, [[(0.85, 1), (0, 1), (0, 0), (0.85, 0)], [(0, 0.5), (0.75, 0.5)]]),
    "I": (0, [[(0, 0), (0, 1)]]),
    "N": (1, [[(0, 0), (0, 1), (1, 0), (1, 1)]]),
}


def segments(word, stroke):
    """Stroke centre lines of a word that fills the grid, in pixels from its lower left corner, as ((x, y), (x, y))."""
    height = HEIGHT - 2 * MARGIN - stroke
    natural = sum(LETTERS[letter][0] for letter in word)
    across = (WIDTH - 2 * MARGIN - len(word) * stroke - (len(word) - 1) * GAP) / natural
    left, low = MARGIN + stroke / 2, MARGIN + stroke / 2
    found = []
    for letter in word:
        width, strokes = LETTERS[letter]
        for line in strokes:
            points = [(left + across * x, low + height * y) for x, y in line]
            found += zip(points, points[1:])
        left += across * width + stroke + GAP
    return found


def draw(word, stroke):
    """Rows of booleans, top row first."""
    ink = [[False] * WIDTH for _ in range(HEIGHT)]
    reach = stroke / 2
    for (x0, y0), (x1, y1) in segments(word, stroke):
        dx, dy = x1 - x0, y1 - y0
        square = dx * dx + dy * dy
        for row in range(max(0, int(min(y0, y1) - reach)), min(HEIGHT, int(max(y0, y1) + reach) + 2)):
            for column in range(max(0, int(min(x0, x1) - reach)), min(WIDTH, int(max(x0, x1) + reach) + 2)):
                along = min(1.0, max(0.0, ((column - x0) * dx + (row - y0) * dy) / square))
                if math.hypot(column - x0 - along * dx, row - y0 - along * dy) <= reach:
                    ink[HEIGHT - 1 - row][column] = True
    return ink


def count(ink):
    return sum(map(sum, ink))


def outline(ink):
    """Ink with a blank to its left, right, top or bottom, in scan order."""
    def blank(row, column):
        return not (0 <= row < HEIGHT and 0 <= column < WIDTH and ink[row][column])

    return [(row, column) for row in range(HEIGHT) for column in range(WIDTH) if ink[row][column]
            and any(blank(row + i, column + j) for i, j in ((0, -1), (0, 1), (-1, 0), (1, 0)))]


def wordmark():
    thin, thick = 20.0, 80.0
    while thick - thin > 1e-3:
        middle = (thin + thick) / 2
        thin, thick = (middle, thick) if count(draw("SKEIN", middle)) < CILIA else (thin, middle)
    ink = draw("SKEIN", thick)
    for row, column in outline(ink)[: count(ink) - CILIA]:
        ink[row][column] = False
    return ink, thick


def main():
    ink, stroke = wordmark()
    path = Path(__file__).with_name("wordmark.pbm")
    digits = "".join("1" if pixel else "0" for row in ink for pixel in row)
    lines = [digits[i:i + 70] for i in range(0, len(digits), 70)]
    path.write_text(f"P1\n# SKEIN, {CILIA} cilia; drawn by make_wordmark.py\n{WIDTH} {HEIGHT}\n" + "\n".join(lines) + "\n")
    print(f"{path.name}: {WIDTH} x {HEIGHT}, {count(ink)} of ink, stroke {stroke:.2f}")


if __name__ == "__main__":
    main()
