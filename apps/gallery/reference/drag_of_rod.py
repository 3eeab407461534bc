"""Drag on a cylinder of 20 diameters in Stokes flow in a cube of periods 1.5 lengths wide, by rings of forces within it (apps/flow/rods.py):
force at 0.7 m/s sideways and lengthwise in a fluid of 1 Pa s, in N."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "flow"))
import rods

print("sideways {:.6g}  lengthwise {:.6g}".format(*0.7 * rods.drag_of_cylinder(1.0, 0.025, 1.5)))
