#!/usr/bin/python3
"""Makes front_page.gif, the picture at the top of README.md, from shipped scenes: runs them, draws a movie of each, and puts these side by side.

  front_page.py [SKEIN [FOLDER]]    default: build/bin/skein, and a temporary folder for runs
"""

import pathlib
import subprocess
import sys
import tempfile

from PIL import Image, ImageSequence

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TILE, FRAMES, COLUMNS, COLOURS, RATE = (280, 210), 48, 3, 96, 16
# Scene, seconds that are shown, further keys, options of skein draw.
SCENES = (
    ("cilia_carpet/carpet_8x8", (144, 216), (), ("--colour", "phase")),
    ("gripper/gripper", (0, 5), (), ()),
    ("net/net", (1.5, 2.1), (), ()),
    ("contact/minicircle", (0, 12), (), ()),
    ("active_matter/pit_96", (0, 20), ("time.duration=20",), ("--colour", "rod")),
    ("millipede/one_bot", (12, 84), (), ()),
)


def frames_of(skein, scene, shown, keys, options, folder):
    """The frames of a scene's movie, as many as FRAMES."""
    out, movie = folder / pathlib.Path(scene).name, folder / (pathlib.Path(scene).name + ".gif")
    begin, end = shown
    every = [f"--set=output.trajectory={(end - begin) / FRAMES}", "--set=output.precision=single"]
    subprocess.run([skein, "run", ROOT / "apps" / f"{scene}.toml", "--out", out, "--quiet", "--overwrite", f"--until={end}",
                    *every, *(f"--set={key}" for key in keys)], check=True, cwd=ROOT)
    subprocess.run([skein, "draw", out, "--movie", movie, "--no-words", "--size", f"{TILE[0]}x{TILE[1]}", "--from", str(begin),
                    "--until", str(end), *options], check=True, cwd=ROOT)
    drawn = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(movie))]
    return [drawn[i * len(drawn) // FRAMES] for i in range(FRAMES)]


def main(skein, folder):
    rows = -(-len(SCENES) // COLUMNS)
    sheet = [Image.new("RGB", (COLUMNS * TILE[0], rows * TILE[1]), "white") for _ in range(FRAMES)]
    for number, scene in enumerate(SCENES):
        for image, frame in zip(sheet, frames_of(skein, *scene, folder)):
            image.paste(frame, (number % COLUMNS * TILE[0], number // COLUMNS * TILE[1]))
    palette = sheet[FRAMES // 2].quantize(COLOURS, dither=Image.Dither.NONE)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in sheet]
    target = HERE / "front_page.gif"
    flat[0].save(target, save_all=True, append_images=flat[1:], duration=1000 // RATE, loop=0, optimize=True)
    print(f"{target}: {target.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/bin/skein").resolve()
    if len(sys.argv) > 2:
        main(program, pathlib.Path(sys.argv[2]))
    else:
        with tempfile.TemporaryDirectory() as runs:
            main(program, pathlib.Path(runs))
