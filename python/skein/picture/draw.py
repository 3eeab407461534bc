"""Pictures and movies of a run: skein.draw("out/nest"), and `skein draw out/nest` on the command line."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from . import flow, plain_stage, sheet, vtk_stage
from .view import Choice, View
from .. import results as results_of
from ..needs import NotResults

SIZE = 1600, 1200
MOVIE_SIZE = 1280, 960


def draw(run, to=None, time=None, size=None, renderer="auto", words=True, samples=2, **choice):
    """Draws the frame nearest to a time, s (the last where none is given), into OUT/picture.png or `to`; returns the path. `run`: a directory or skein.open's
    results. `choice`: the fields of view.Choice, such as colour="strain", camera=(0, -1, 0.3)."""
    from PIL import Image
    run, choice = _asked(run, choice)
    frames = _frames(run, choice) or [-1]  # of none View reports why
    frame = frames[-1] if time is None else min(frames, key=lambda k: abs(run.time[k] - time))
    width, height = size or SIZE
    view, stage = _staged(run, [frame], choice, renderer, width, height, samples)
    page = sheet.Sheet(width, height, run.title, view.scales, words, view.legend, view.marks(width, height))
    to = Path(to or run.directory / "picture.png")
    _saved(to, lambda path: Image.fromarray(_one(view, stage, page, frame)).save(path, optimize=True))
    return to


class Pictures:
    """Images [height, width, 3] of some frames of a run, to one scale and from one side, for figures of one's own.

    images, times    of the frames
    scale            of the colours, None where they have none
    """

    def __init__(self, run, times, size=(800, 600), renderer="auto", samples=2, **choice):
        run, choice = _asked(run, choice)
        frames = [run.frames.nearest(time) if len(run.frames) else 0 for time in times]
        self.width, self.height = size
        self.view, stage = _staged(run, frames, choice, renderer, *size, samples)
        self.times = [float(run.time[frame]) for frame in frames]
        self.scale = self.view.paint.scale
        self.images = [stage.draw(self.view, self.view.shown(frame)) for frame in frames]

    def show(self, axes, number=0):
        """The image in matplotlib's axes, which then count in pixels from its upper left corner."""
        axes.imshow(self.images[number], interpolation="antialiased")
        axes.set_axis_off()

    def pixels(self, points):
        """Where points [points, 3] are seen: [points, 2]."""
        place, _ = self.view.camera.project(np.asarray(points, float))
        return 0.5 * np.array([self.width, self.height]) + 0.5 * self.height * place * [1, -1]

    def bar(self, figure, place):
        """A level colour bar."""
        sheet.colour_bar(figure, place, self.scale)


def movie(run, to=None, every=1, first=None, last=None, rate=25, size=None, renderer="auto", words=True, samples=1, told=None, **choice):
    """A movie, .mp4 (by ffmpeg) or .gif, of every `every`-th frame from time `first` to `last`, s; returns the path. `told(done, count)` is called
    after each frame."""
    run, choice = _asked(run, choice)
    to = Path(to or run.directory / "movie.mp4")
    frames = [k for k in _frames(run, choice)[::every] if (first is None or run.time[k] >= first) and (last is None or run.time[k] <= last)]
    if not frames:
        raise NotResults(f"{run.directory}: no frames between {first} and {last} s")
    width, height = size or MOVIE_SIZE
    width, height = width - width % 2, height - height % 2
    write = _writer(to, width, height, rate)
    view, stage = _staged(run, frames, choice, renderer, width, height, samples)
    page = sheet.Sheet(width, height, run.title, view.scales, words, view.legend, view.marks(width, height))

    def images():
        for done, frame in enumerate(frames, 1):
            yield _one(view, stage, page, frame)
            if told:
                told(done, len(frames))

    _saved(to, lambda path: write(path, images()))
    return to


def _asked(run, choice):
    unknown = set(choice) - set(Choice.__dataclass_fields__)
    if unknown:
        raise TypeError(f"no choice {', '.join(sorted(unknown))}; there are {', '.join(Choice.__dataclass_fields__)}")
    run = run if isinstance(run, results_of.Results) else results_of.open(run)
    if flow.wanted(Choice(**choice)) and not len(run.frames):
        return run.of_fluid(flow.Flow(run, Choice(**choice)).rarest), Choice(**choice)
    if not len(run.frames) and run.checkpoints and run.physics.get("rods"):
        print(f"note: {run.directory} has no frames (output.trajectory); its newest checkpoint, of step {run.checkpoints[-1]}, is drawn", file=sys.stderr)
        run = run.of_checkpoint()
    return run, Choice(**choice)


def _frames(run, choice):
    """Frames that may be drawn: with a fluid, those at which it has one."""
    return flow.Flow(run, choice).frames(run) if flow.wanted(choice) else list(range(len(run.frames)))


def _staged(run, frames, choice, renderer, width, height, samples):
    """The view and what draws it: VTK where it can, else matplotlib with fewer faces, and a word of why."""
    reason = vtk_stage.why_not() if renderer != "plain" else "asked for"
    if renderer == "vtk" and reason:
        raise NotResults(f"no picture by VTK: {reason}")
    if reason:
        choice.detail *= plain_stage.DETAIL
    view = View(run, frames, choice, width / height)
    if not reason:
        return view, vtk_stage.Stage(width, height, samples)
    if renderer == "auto":
        print(f"note: drawn by matplotlib, without shadows: {reason}", file=sys.stderr)
    return view, plain_stage.Stage(width, height)


def _one(view, stage, page, frame):
    return page.filled(stage.draw(view, view.shown(frame)), when(view.results, frame))


def when(results, frame):
    """Words for the time of a frame; a relaxation has steps alone."""
    if results.relaxed:
        return f"{results.frames.step[frame]} steps"
    return sheet.time_words(float(results.time[frame]), float(results.time[-1]))


def _saved(to, write):
    """Under a temporary name, then renamed."""
    to.parent.mkdir(parents=True, exist_ok=True)
    part = to.with_name(f".part_{to.name}")
    try:
        write(part)
        part.replace(to)
    finally:
        part.unlink(missing_ok=True)


def _writer(to, width, height, rate):
    if to.suffix == ".gif":
        return lambda path, images: _gif(path, images, rate)
    if to.suffix not in (".mp4", ".mkv", ".webm"):
        raise NotResults(f"{to}: no such kind of movie; give a name that ends in .mp4, .webm, .mkv or .gif")
    if not shutil.which("ffmpeg"):
        raise NotResults(f"{to}: ffmpeg is not here (Debian: ffmpeg); a movie.gif needs none")
    return lambda path, images: _ffmpeg(path, images, width, height, rate)


def _ffmpeg(path, images, width, height, rate):
    codec = ["-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "32"] if path.suffix == ".webm" else ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-", *codec, str(path)]
    with tempfile.TemporaryFile() as words:
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=words)
        try:
            for image in images:
                encoder.stdin.write(np.ascontiguousarray(image).tobytes())
        except BrokenPipeError:
            pass
        finally:
            encoder.stdin.close()
            code = encoder.wait()
        if code:
            words.seek(0)
            raise NotResults(f"ffmpeg ended with code {code}: {words.read().decode(errors='replace').strip()}")


def _gif(path, images, rate):
    from PIL import Image
    frames = [Image.fromarray(image).convert("P", palette=Image.Palette.ADAPTIVE, colors=128) for image in images]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0, optimize=True)
