"""How figures look: two inks, few spines, headings on the left."""

INK, QUIET = "#22252b", "#7a7f87"


def bare(axes, *sides):
    for side in ("left", "right", "top", "bottom"):
        axes.spines[side].set_visible(side in sides)
        axes.spines[side].set_color(QUIET)
    axes.tick_params(colors=QUIET, labelcolor=INK, length=3)


def heading(axes, text, pad=8):
    axes.set_title(text, loc="left", color=INK, fontsize=10.5, pad=pad)
