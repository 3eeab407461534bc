"""skein draw: pictures, movies and pages of any run's results."""

import argparse
import json
import sys
import time as clock
from pathlib import Path

from .needs import NotResults, in_words, need
from .parser import Parser


def parser():
    p = Parser(prog="skein draw", takes="one directory", description="Draws what a run has written: a picture of its last frame, or of a time; a movie; a page for browsers.",
               epilog="examples: skein draw out/nest --colour contact_force | skein draw out/carpet --movie carpet.mp4 --every 2 | skein draw out/nest --html nest.html")
    p.add_argument("out", type=Path, metavar="OUT", help="directory of a run's results")
    p.add_argument("--to", type=Path, metavar="PNG", help="picture to write; default OUT/picture.png")
    p.add_argument("--time", type=float, metavar="S", help="of the frame, s; default: the last")
    p.add_argument("--colour", "--color", default="auto", help="by strain, curvature, bending, speed, energy, contact_force, height, radius, phase (of a beat), rod, group or magnetisation; "
                                                              "default: curvature of one group, else the group")
    p.add_argument("--slice", type=_plane, action="append", default=[], metavar="AXIS=S", help="the fluid in a plane, e.g. z=0.5, m; may be repeated")
    p.add_argument("--q", type=_level, metavar="VALUE|auto", help="surfaces of equal Q of the fluid, 1/s^2, around its vortices; auto: around 2 %% of its volume")
    p.add_argument("--fluid", default="auto", metavar="QUANTITY", help="colour of slices and surfaces: speed, vorticity (its magnitude), vorticity_x, _y, _z, velocity_x, _y, _z, q or pressure; "
                                                                       "default: speed, else the vorticity that the run has")
    p.add_argument("--fluid-range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="of the colours of the fluid, SI units")
    p.add_argument("--range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="of the colours, SI units")
    p.add_argument("--group", action="append", default=[], metavar="NAME", help="only this group; may be repeated")
    p.add_argument("--camera", type=_vector, metavar="X,Y,Z", help="direction from which to look; default: by the shape of the scene")
    p.add_argument("--up", type=_vector, metavar="X,Y,Z", help="axis that points up; default: against gravity, else z")
    p.add_argument("--zoom", type=float, default=1.0, help="into the middle of the picture")
    p.add_argument("--no-walls", dest="walls", action="store_false", help="leave out walls")
    p.add_argument("--ground", type=_ground, default="auto", metavar="yes|no|HEIGHT", help="a level plane that catches shadows; default: where rods stand or lie on one")
    p.add_argument("--stripe", choices=("auto", "yes", "no"), default="auto", help="a dark stripe along the director d1, which shows twist; default: in scenes with the observable 'knots'")
    p.add_argument("--size", type=_size, metavar="WxH", help="in pixels; default 1600x1200, of movies 1280x960")
    p.add_argument("--detail", type=float, default=1.0, help="of the surfaces: 0.2 is quick, 4 fine")
    p.add_argument("--renderer", choices=("auto", "vtk", "plain"), default="auto", help="VTK (shadows), or matplotlib alone; default: VTK where it is there")
    p.add_argument("--no-words", dest="words", action="store_false", help="no title, time and colour bar")
    p.add_argument("--movie", type=Path, metavar="FILE", help="write a movie, .mp4, .webm or .gif, in place of a picture")
    p.add_argument("--html", type=Path, metavar="FILE", help="write a page for browsers, that turns and plays, in place of a picture")
    p.add_argument("--paraview", type=Path, metavar="FILE", help="write a state for ParaView (view.py) in place of a picture")
    p.add_argument("--every", type=int, metavar="N", help="of a movie or page: every N-th frame; default: all, in a page as many as fit 5 MB")
    p.add_argument("--from", dest="first", type=float, metavar="S", help="of a movie or page: first time, s")
    p.add_argument("--until", dest="last", type=float, metavar="S", help="of a movie or page: last time, s")
    p.add_argument("--rate", type=float, default=25, help="of a movie: frames per second; default 25")
    p.add_argument("--json", action="store_true", help="the name of the file and the time taken, as JSON")
    return p


def _vector(text):
    numbers = [float(word) for word in text.split(",")]
    if len(numbers) != 3 or not any(numbers):
        raise argparse.ArgumentTypeError(f"'{text}' is no direction; give x,y,z")
    return tuple(numbers)


def _plane(text):
    axis, _, place = text.partition("=")
    try:
        if axis in ("x", "y", "z"):
            return axis, float(place)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is no plane; give e.g. z=0.5")


def _level(text):
    try:
        return text if text == "auto" else float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no level of Q; give a number, 1/s^2, or auto") from None


def _size(text):
    try:
        width, height = (int(word) for word in text.split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no size; give e.g. 1600x1200") from None
    if min(width, height) < 64:
        raise argparse.ArgumentTypeError(f"'{text}' is below 64x64")
    return width, height


def _ground(text):
    return {"yes": True, "no": False, "auto": "auto"}[text] if text in ("yes", "no", "auto") else float(text)


def main(words=None):
    in_words(lambda: _draw(parser().parse_args(words)), code=2, code_of_damage=5)


def _draw(given):
    need("numpy", "h5py", "matplotlib")
    from .picture.draw import draw, movie
    from .picture.page import page
    from .picture.state import state
    choice = {"colour": given.colour, "limits": given.range and tuple(given.range), "groups": tuple(given.group), "walls": given.walls, "ground": given.ground,
              "stripe": {"yes": True, "no": False}.get(given.stripe, "auto"), "camera": given.camera, "up": given.up, "zoom": given.zoom, "detail": given.detail,
              "slices": tuple(given.slice), "q": given.q, "fluid": given.fluid, "fluid_limits": given.fluid_range and tuple(given.fluid_range)}
    began = clock.monotonic()
    common = {"size": given.size, "renderer": given.renderer, "words": given.words, **choice}
    if given.movie:
        to = movie(given.out, given.movie, every=given.every or 1, first=given.first, last=given.last, rate=given.rate, told=_teller(began) if sys.stderr.isatty() else None, **common)
    elif (given.paraview or given.html) and (given.slice or given.q is not None):
        raise NotResults("--slice and --q are of pictures and movies; ParaView opens fields.xdmf and fluid_NAME.xdmf")
    elif given.paraview:
        to = state(given.out, given.paraview, given.time, **choice)
    elif given.html:
        to = page(given.out, given.html, every=given.every, first=given.first, last=given.last, time=given.time, **choice)
    else:
        to = draw(given.out, given.to, given.time, **common)
    seconds = clock.monotonic() - began
    print(json.dumps({"file": str(to), "seconds": seconds}) if given.json else f"{to}  ({seconds:.1f} s)")


def _teller(began):
    """A line that is written over frame by frame, with the time that is left."""
    def progress(done, count):
        spent = clock.monotonic() - began
        left = f"{_duration(spent / done * (count - done))} left" if done < count else f"{_duration(spent)}"
        print(f"\rframe {done} of {count}, {left}\033[K", end="\n" if done == count else "", file=sys.stderr, flush=True)
    return progress


def _duration(seconds):
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min {rest} s" if minutes else f"{rest} s"
