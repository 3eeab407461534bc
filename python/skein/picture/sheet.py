"""A drawn image with its words: title, time and colour bar."""

import numpy as np

from ..style import INK, QUIET


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
    axes.set_xlabel(scale.words, color=INK, fontsize=1.1 * size, labelpad=3)


class Sheet:
    """Made once, filled frame by frame."""

    def __init__(self, width, height, title, scale, words=True):
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
        if scale is not None and words:
            colour_bar(self.figure, [0.36, 0.062, 0.28, 0.011], scale, 10 * em)

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
