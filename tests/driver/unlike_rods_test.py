"""Rods of a file with sizes of their own that touch each other, walls and joints: the same bits on any ranks, threads and lanes, with owners that change, and after a restart."""

import unittest

import numpy

from driver import DriverTest
from scene_text import scene_text

RADIUS, SPACING = 1e-3, 1.9e-3
LAW = {"law": "hertz", "stiffness": 2e4, "damping": 0.05}
ROUGH = LAW | {"friction": "memory", "static_friction": 0.3}
OF_LISTS = {"candidates", "rebuilds", "skinm"}  # columns of lists, which each rank makes for itself
BOUNCING = {"law": "hertz", "restitution": 0.4, "collision_time": 1e-3, "collision_speed": 0.1}


def rows(count, seed=3):
    """Layers of rods that cross: origins, directions, lengths and radii. The thickest touch at the start."""
    draw = numpy.random.default_rng(seed)
    lengths, radii = draw.uniform(0.03, 0.06, count), draw.uniform(0.7, 1.0, count) * RADIUS
    along = numpy.arange(count) // 5 % 2
    tangents = numpy.stack([along, 1 - along, 0 * along], axis=1) + draw.uniform(-0.02, 0.02, (count, 3)) * [1, 1, 0]
    place = 0.01 * (numpy.arange(count) % 5)
    origins = numpy.stack([numpy.where(along, 0, place), numpy.where(along, place, 0), RADIUS + numpy.arange(count) // 5 * SPACING], axis=1)
    return numpy.column_stack([origins, tangents, lengths, radii])


class UnlikeRods(DriverTest):
    def write(self, count=43, file="rods.csv", start="free", **tables):
        names = "x,y,z,tx,ty,tz,length,radius"
        numpy.savetxt(self.directory / file, rows(count), delimiter=",", header=names, comments="", fmt="%.17g")
        group = {"name": "hairs", "material": {"density": 1200.0, "youngs_modulus": 1e6}, "section": {"radius": 5 * RADIUS}, "shape": {"length": 1.0, "elements": 8},
                 "placement": {"kind": "file", "file": file}} | ({"start": start} if start != "free" else {})
        output = {"trajectory": 2e-3, "series": 1e-3, "precision": "double"} | tables.pop("output", {})
        scene = {"time": {"duration": 8e-3}, "rods": [group], "load": [{"kind": "gravity"}], "damping": [{"kind": "uniform", "rate": 10.0}], "contact": ROUGH,
                 "wall": [{"name": "dish", "kind": "plane"} | ROUGH], "output": output}
        self.scene.write_text(scene_text({key: value for key, value in (scene | tables).items() if value is not None}))

    def test_same_bits_however_they_are_run(self):
        joint = {"kind": "spherical", "between": ["hairs", "hairs"], "pairs": "listed", "first": [0, 7], "second": [1, 8], "at": [0.5, 0.2], "stiffness": 20.0}
        scenes = {"whole": {}, "rough": {"contact": LAW | {"friction": "regularised", "kinetic_friction": 0.3, "slip_speed": 1e-2},
                                         "wall": [{"name": "dish", "kind": "plane"} | LAW | {"friction": "regularised", "kinetic_friction": 0.3, "slip_speed": 1e-2}]},
                  "audited": {"output": {"audit": True}}, "bouncing": {"contact": BOUNCING}, "filtered": {"damping": [{"kind": "laplacian", "rate": 100.0, "order": 1}]},
                  "joined": {"joint": [joint], "contact": ROUGH | {"joined": True}}}
        for name, tables in scenes.items():
            self.write(**tables)
            self.run_skein(name, "--until", "0.004")
            self.run_skein(name)
            summary = self.summary(name)
            with self.subTest(scene=name):
                self.assertGreater(self.series(name)["touching_pairs"].max(), 10)
                for out, arguments, layout in (("ranks", (), {"ranks": 2}), ("moved", ("--balance", "always"), {"ranks": 3}), ("threads", (), {"threads": 2}),
                                               ("four", ("--lanes", "4"), {}), ("one", ("--lanes", "1"), {"ranks": 2}), ("two", ("--lanes", "2"), {})):
                    self.run_skein(out, "--overwrite", *arguments, **layout)
                    self.assertEqual(self.digest(out), summary["digest"], out)
                    if name == "audited":
                        for column in set(self.series(name).dtype.names) - OF_LISTS:
                            numpy.testing.assert_array_equal(self.series(out)[column], self.series(name)[column], f"{out}: {column}")

    def test_an_audit_closes(self):
        """Works of loads and damping of rods in lanes of one tile, clamped ones and free ones, are those of the same rods one by one."""
        for start in ("free", "clamped"):
            with self.subTest(start=start):
                self.write(count=13, start=start, contact=None, wall=None, output={"audit": True})
                self.run_skein("all", "--overwrite")
                every = self.series("all")
                self.assertLess(abs(every["energy_defectJ"]).max(), 1e-3 * abs(every["work_loadsJ"]).max())
                self.assertGreater(abs(every["work_loadsJ"]).max(), 0)
                text = (self.directory / "rods.csv").read_text().splitlines()
                columns = ("work_loadsJ", "work_wallsJ", "dissipatedJ")
                total = {column: 0.0 for column in columns}
                dt = self.plan()["dt"]
                for row in text[1:]:
                    (self.directory / "rods.csv").write_text(f"{text[0]}\n{row}\n")
                    self.run_skein("one", "--overwrite", "--set", f"time.dt={dt!r}")
                    for column in columns: total[column] = total[column] + self.series("one")[column]
                for column in columns:
                    numpy.testing.assert_allclose(every[column], total[column], rtol=1e-9, atol=1e-12 * abs(every["work_loadsJ"]).max(), err_msg=column)

    def test_limits_are_those_of_the_smallest(self):
        """Contact and drag limit the step by the lightest rod: a file with one thinner rod has a shorter step, and the same as a file of that rod alone."""
        self.write(count=9)
        before = self.plan()["dt"]
        text = (self.directory / "rods.csv").read_text().splitlines()
        thin = text[-1].rsplit(",", 1)[0] + f",{0.3 * RADIUS}"
        (self.directory / "rods.csv").write_text("\n".join([*text[:-1], thin]) + "\n")
        both = self.plan()
        (self.directory / "rods.csv").write_text("\n".join([text[0], thin]) + "\n")
        alone = self.plan()
        self.assertLess(both["limit"], 0.9 * before)
        self.assertEqual(both["limit"], alone["limit"])


if __name__ == "__main__":
    unittest.main()
