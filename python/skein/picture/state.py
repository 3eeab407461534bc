"""A view of a run for ParaView: a Python state, which File > Load State opens, and pvpython runs."""

from pathlib import Path

from .colours import QUANTITIES
from .draw import _asked, _saved
from .view import View
from ..needs import NotResults

ARRAYS = {"strain": "strain", "curvature": "curvature", "speed": "velocity", "energy": "energy", "contact_force": "contact_force", "radius": "radius"}

SCRIPT = '''# ParaView: File > Load State, or pvpython {name}. Rods of "{title}" as tubes, coloured by {array}.
from paraview.simple import *

rods = PVDReader(registrationName="rods", FileName={rods!r})
tubes = Tube(registrationName="tubes", Input=rods)
tubes.Scalars = ["POINTS", "radius"]
tubes.VaryRadius = "By Absolute Scalar"
tubes.NumberofSides = {sides}
view = GetActiveViewOrCreate("RenderView")
view.Background = [1.0, 1.0, 1.0]
view.UseColorPaletteForBackground = 0
view.OrientationAxesVisibility = 0
shown = Show(tubes, view)
ColorBy(shown, ("POINTS", {array!r}))
colours = GetColorTransferFunction({array!r})
colours.ApplyPreset({preset!r}, True)
colours.RescaleTransferFunction({low!r}, {high!r})
shown.SetScalarBarVisibility(view, True)
bar = GetScalarBar(colours, view)
bar.TitleColor = bar.LabelColor = [0.13, 0.14, 0.17]
{walls}animation = GetAnimationScene()
animation.UpdateAnimationUsingDataTimeSteps()
animation.AnimationTime = {time!r}
Render(view)
view.CameraPosition = {eye}
view.CameraFocalPoint = {target}
view.CameraViewUp = {up}
view.CameraViewAngle = {angle}
Render(view)
'''
WALLS = '''walls = PVDReader(registrationName="walls", FileName={walls!r})
around = Show(walls, view)
around.Representation = "Feature Edges"
around.AmbientColor = around.DiffuseColor = [0.6, 0.63, 0.68]
'''


def state(run, to=None, time=None, **choice):
    """Writes OUT/view.py or `to`, and returns the path."""
    run, choice = _asked(run, choice)
    if not (run.directory / "rods.pvd").exists():
        raise NotResults(f"{run.directory}: no rods.pvd; set output.paraview = \"vtp\" in the scene")
    if choice.colour == "auto":
        choice.colour = "curvature"
    if choice.colour not in ARRAYS:
        raise NotResults(f"no colour '{choice.colour}' in ParaView's files; there are {', '.join(ARRAYS)}")
    frame = len(run.frames) - 1 if time is None else run.frames.nearest(time)
    view = View(run, [frame], choice, 16 / 9)
    to = Path(to or run.directory / "view.py")
    preset = "Cool to Warm" if QUANTITIES[choice.colour][3] == "RdBu_r" else "Viridis (matplotlib)"
    pvd = run.directory.resolve() / "walls.pvd"
    text = SCRIPT.format(name=to.name, title=run.title.replace("\n", " "), rods=str(run.directory.resolve() / "rods.pvd"), sides=max(8, min(view.sides, 24)),
                         eye=view.camera.eye.tolist(), target=view.camera.target.tolist(), up=view.camera.up.tolist(), angle=float(view.camera.angle),
                         array=ARRAYS[choice.colour], preset=preset, low=float(view.paint.scale.low), high=float(view.paint.scale.high),
                         walls=WALLS.format(walls=str(pvd)) if pvd.exists() and choice.walls else "", time=float(run.time[frame]))
    _saved(to, lambda path: path.write_text(text))
    return to
