"""A drawn image with its words: title, time and colour bar."""

import numpy as np

from ..style import INK, QUIET


MOST_NAMED = 12  # groups


def blank(width, height):
    """A white figure that pyplot does not keep, so that a program may draw any number of pictures."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    figure = Figure(figsize=(width / 100, height / 100), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def colour_bar(figure, place, scale, size=9):
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    axes = figure.add_axes(place)
    bar = figure.colorbar(ScalarMappable(Normalize(scale.factor * scale.low, scale.factor * scale.high), scale.colours), cax=axes, orientation="horizontal")
    if scale.ticks:
        bar.set_ticks([scale.factor * value for value, _ in scale.ticks], labels=[words for _, words in scale.ticks])
    bar.outline.set_visible(False)
    axes.tick_params(length=0, labelcolor=INK, labelsize=size)
    if not scale.ticks:
        _apart(figure, axes, bar, size)
    axes.set_xlabel(scale.words, color=INK, fontsize=1.1 * size, labelpad=3)


def _apart(figure, axes, bar, size):
    """Ticks with as few digits as tell them apart, and as many as do not touch each other."""
    from matplotlib.ticker import MaxNLocator
    low, high = bar.vmin, bar.vmax
    room = axes.get_window_extent().width
    for count in (5, 4, 3, 2, 1):
        ticks = MaxNLocator(count, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        slack = 1e-9 * (high - low)
        ticks = ticks[(ticks >= low - slack) & (ticks <= high + slack)]
        if count == 1 and len(ticks) < 2:
            ticks = np.array([low, high])
        digits = next((d for d in range(16) if len({f"{tick:.{d}f}" for tick in ticks}) == len(ticks) and np.allclose(np.round(ticks, d), ticks, rtol=0, atol=0.01 * (high - low))), 15)
        words = [f"{tick:.{digits}f}".replace("-", "\u2212") for tick in ticks]
        needed = 0.62 * size * figure.dpi / 72 * (max(map(len, words)) + 1)
        if len(ticks) < 2 or needed < room * np.min(np.diff(ticks)) / (high - low):
            break
    bar.set_ticks(ticks, labels=words)


class Sheet:
    """Made once, filled frame by frame. `scales`: of the colour bars; `legend`: [(words, colour)], where there is none for rods; `marks`:
    [(x, y, words, "below" or "left")], x and y in pixels from the upper left corner."""

    def __init__(self, width, height, title, scales, words=True, legend=(), marks=()):
        self.size = width, height
        self.figure = blank(width, height)
        axes = self.figure.add_axes([0, 0, 1, 1])
        axes.set_axis_off()
        self.image = axes.imshow(np.full((height, width, 3), 255, np.uint8), interpolation="nearest", aspect="auto")
        em = height / 1000
        self.time = self.figure.text(0.98, 0.965, "", color=QUIET, fontsize=13 * em, ha="right", va="center")
        if words:
            self.figure.text(0.02, 0.965, title, color=INK, fontsize=15 * em, va="center")
        else:
            self.time.set_visible(False)
        if not words:
            return
        scales = [scale for scale in scales if scale is not None]
        shares = len(scales) + bool(legend)
        for number, scale in enumerate(scales):
            middle = (number + 1) / (shares + 1) if shares > 1 else 0.5
            colour_bar(self.figure, [middle - 0.14, 0.062, 0.28, 0.011], scale, 10 * em)
        if legend:
            self._legend(legend, shares / (shares + 1) if shares > 1 else 0.5, em)
        self._marks(axes, marks, em)

    def _legend(self, entries, middle, em):
        from matplotlib.patches import Patch
        entries = [*entries[:MOST_NAMED - 1], (f"and {len(entries) - MOST_NAMED + 1} more", (1, 1, 1))] if len(entries) > MOST_NAMED else entries
        longest = max(len(words) for words, _ in entries)
        columns = max(1, min(len(entries), 5, int((0.9 if middle == 0.5 else 0.4) * self.size[0] / (em * (longest + 5) * 9))))
        self.figure.legend(handles=[Patch(facecolor=colour, label=words) for words, colour in entries], loc="center", bbox_to_anchor=(middle, 0.045), ncol=columns,
                           frameon=False, fontsize=11 * em, labelcolor=INK, handlelength=1, handleheight=1, columnspacing=1.5)

    def _marks(self, axes, marks, em):
        for x, y, words, where in marks:
            below, named = where.startswith("below"), where.endswith("all")
            far = ((25 if below else 40) if named else 7) * em
            axes.annotate(words, (x, y), (0, -far) if below else (-far, 0), textcoords="offset points", color=INK, fontsize=(11 if named else 10) * em,
                          ha="center" if below or named else "right", va="top" if below else "center", rotation=90 if named and not below else 0, annotation_clip=False)

    def filled(self, image, time):
        """[height, width, 3]."""
        self.image.set_data(image)
        self.time.set_text(time)
        self.figure.canvas.draw()
        return np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()


def time_words(time, last):
    """With as many digits as tell frames apart."""
    for power, unit in ((0, "s"), (-3, "ms"), (-6, "µs")):
        if last >= 10.0**power or power == -6:
            return f"{time / 10.0**power:.{3 if last / 10.0**power < 10 else 2}f} {unit}"
