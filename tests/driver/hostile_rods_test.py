"""Hostile files of rods: three hundred cut, mixed up, mistyped and random ones. Each is refused in one sentence that names the file and the place in it, or is
read as the sound file is."""

import io
import json
import re
import struct
import subprocess
import unittest
import zipfile

import h5py
import numpy

from driver import SKEIN, DriverTest

SCENE = """
[time]
duration = 0.001
[[rods]]
name = "traced"
material = {{density = 1000.0, youngs_modulus = 1e6}}
section.radius = 0.01
shape = {{length = 0.5, elements = 6}}
placement = {{kind = "file", file = "{name}"}}
"""
RODS = 5
LEAST = 300
# Places in a file that a message may name.
PLACE = re.compile(r":\d+[:,]|:\d+: |row \d+|dataset '|array '|is damaged|cut short|'BCC'|of type|dimensions|floats of|curve \d+ is closed|behind its last curve|header counts|no \.npz|as HDF5|contains no|'points'|'offsets'|holds|compressed|unknown|'normals'")


def curves(seed=4):
    """Helices of 5 to 9 points."""
    random = numpy.random.default_rng(seed)
    for rod in range(RODS):
        u = numpy.linspace(0, 1, 5 + rod)
        yield numpy.round(numpy.stack([0.2 * numpy.cos(u + rod), 0.2 * numpy.sin(u + rod), rod + u * random.uniform(0.2, 0.5)], axis=1), 6)


def tables():
    """Columns and rows of a sound file with a row per point, one with a row per rod, and a tree."""
    points = [["fibre", "x", "y", "z", "radius"]]
    for rod, curve in enumerate(curves()):
        points += [[f"f{rod}", *(f"{x:.6f}" for x in p), "0.011"] for p in curve]
    rods = [["x", "y", "z", "tx", "ty", "tz", "length", "radius"]]
    rods += [[*(f"{x:.6f}" for x in curve[0]), "0", str(rod), "1", "0.4", "0.012"] for rod, curve in enumerate(curves())]
    swc = [["#", "id", "type", "x", "y", "z", "radius", "parent"]]
    number = 0
    for rod, curve in enumerate(curves()):
        for k, p in enumerate(curve):
            above = -1 if number == 0 else 3 if k == 0 else number
            number += 1
            swc.append([str(number), "3", *(f"{x:.6f}" for x in p), "0.013", str(above)])
    return {"points.csv": points, "points.tsv": points, "rods.csv": rods, "tree.swc": swc}


SEPARATOR = {"csv": ",", "tsv": "\t", "swc": " "}


def joined(name, table):
    return ("\n".join(SEPARATOR[name[-3:]].join(row) for row in table) + "\n").encode()


class Case:
    """A file: `sound` says that it must be read as the one that it comes from, `refused` that it must not be read."""

    def __init__(self, title, name, data, sound=False, refused=True):
        self.title, self.name, self.data, self.sound, self.refused = title, name, data, sound, refused and not sound


def text_cases():
    random = numpy.random.default_rng(11)
    for name, table in tables().items():
        good, swc = joined(name, table), name.endswith("swc")
        yield Case("as it is", name, good, sound=True)
        yield Case("CRLF", name, good.replace(b"\n", b"\r\n"), sound=True)
        yield Case("empty lines", name, good.replace(b"\n", b"\n\n") + b"\n\n", sound=True)
        yield Case("no last end of line", name, good.rstrip(b"\n"), sound=True)
        yield Case("empty", name, b"")
        yield Case("only the first line", name, good.split(b"\n")[0] + b"\n")
        yield Case("zeros", name, b"\0" * 4096)
        yield Case("one long line", name, b"7" * (3 << 20))
        yield Case("UTF-16", name, good.decode().encode("utf-16"))
        yield Case("carriage returns alone", name, good.replace(b"\n", b"\r"))
        if not swc:
            yield Case("BOM", name, b"\xef\xbb\xbf" + good, sound=True)
            quoted = "\n".join(SEPARATOR[name[-3:]].join(f' "{cell}" ' for cell in row) for row in table)
            yield Case("quotes", name, quoted.encode(), sound=True)
            yield Case("capitals", name, joined(name, [[cell.upper() for cell in table[0]], *table[1:]]), sound=True)
            yield Case("a quote that is not closed", name, good.replace(b"0.", b'"0.', 1))
            yield Case("no names", name, joined(name, table[1:]))
            for column in range(len(table[0])):
                if not (name == "rods.csv" and column > 5) and table[0][column] not in ("fibre", "z", "radius"):  # a row per rod needs no more
                    yield Case(f"without {table[0][column]}", name, joined(name, [row[:column] + row[column + 1:] for row in table]))
                yield Case(f"{table[0][column]} twice", name, joined(name, [row + [row[column]] for row in table]))
                yield Case(f"unknown name of {table[0][column]}", name, joined(name, [table[0][:column] + ["wobble"] + table[0][column + 1:], *table[1:]]))
        for row in random.choice(numpy.arange(1, len(table)), 3, replace=False):
            numbers = range(2, 6) if swc else range(1, len(table[0])) if name.startswith("points") else range(8)
            for word in ("nan", "inf", "-inf", "1e400", "abc", "", "0x1p3", "1,5" if name.endswith("tsv") else "1.5.2", "--1", "\xff\xfe"):
                column = int(random.choice(list(numbers)))
                changed = [list(r) for r in table]
                changed[row][column] = word
                if not (swc and word == ""):
                    yield Case(f"'{word}' in row {row}, column {column}", name, joined(name, changed))
            changed = [list(r) for r in table]
            changed[row] = changed[row][:-1]
            yield Case(f"a value too few in row {row}", name, joined(name, changed))
            changed[row] = table[row] + ["1"]
            yield Case(f"a value too many in row {row}", name, joined(name, changed))
            for value in ("-0.01", "0", "1e-200"):
                if name != "rods.csv" or value != "1e-200":
                    changed = [list(r) for r in table]
                    changed[row][5 if swc else -1] = value
                    yield Case(f"radius {value} in row {row}", name, joined(name, changed))
            changed = [list(r) for r in table]
            changed[row][2 if swc else 1 if name.startswith("points") else 0] = "1e200"
            yield Case(f"1e200 m in row {row}", name, joined(name, changed), refused=name != "rods.csv")
        for size in (0.3, 0.6, 0.9):
            cut = good[:int(size * len(good))]
            yield Case(f"cut at {size}", name, cut[:cut.rfind(SEPARATOR[name[-3:]].encode()) + 1])
        for trial in range(6):
            bytes_of = numpy.frombuffer(good, numpy.uint8).copy()
            at = random.integers(0, len(bytes_of), 3)
            bytes_of[at] = random.integers(0, 256, 3)
            yield Case(f"three random bytes, trial {trial}", name, bytes_of.tobytes(), refused=False)
            yield Case(f"noise, trial {trial}", name, random.integers(0, 256, 3000).astype(numpy.uint8).tobytes())
    yield from cases_of_points()
    yield from cases_of_trees()


def cases_of_points():
    name, table = "points.csv", tables()["points.csv"]
    head, rows = table[0], table[1:]
    mixed = [row for k in range(9) for row in [[r for r in rows if r[0] == f"f{rod}"][k:k + 1] for rod in range(RODS)]]
    yield Case("rows of rods in turn", name, joined(name, [head, *(row[0] for row in mixed if row)]), sound=True)
    yield Case("semicolons", name, joined(name, table).replace(b",", b";"), sound=True)
    yield Case("a comment before the names", name, b"# traced by hand\n" + joined(name, table), sound=True)
    yield Case("diameters", name, joined(name, [[*head[:-1], "diameter"], *([*row[:-1], "0.022"] for row in rows)]), sound=True)
    yield Case("decimal commas", name, joined(name, table).replace(b",", b";").replace(b".", b","))
    yield Case("one point of a rod", name, joined(name, [*table, ["f9", "9", "9", "9", "0.01"]]))
    yield Case("an id without text", name, joined(name, [*table, ["", "9", "9", "9", "0.01"]]))
    yield Case("a point twice", name, joined(name, [*table, ["f9", "9", "9", "9", "0.01"], ["f9", "9", "9", "9", "0.01"]]))
    yield Case("there and back", name, joined(name, [*table, *(["f9", x, "9", "9", "0.01"] for x in ("0", "1", "0"))]))
    yield Case("two columns of ids", name, joined(name, [[*head, "track"], *([*row, row[0]] for row in rows)]))
    yield Case("a column of no use", name, joined(name, [[*head, "intensity"], *([*row, "7"] for row in rows)]))
    yield Case("normals without nz", name, joined(name, [[*head, "nx", "ny"], *([*row, "0", "1"] for row in rows)]))
    yield Case("normals along the rods", name, joined(name, [[*head, "nx", "ny", "nz"], *([*row, "0", "0", "0"] for row in rows)]))
    yield Case("radius and diameter", name, joined(name, [[*head, "diameter"], *([*row, "0.02"] for row in rows)]))


def cases_of_trees():
    name, table = "tree.swc", tables()["tree.swc"]
    yield Case("a parent that is missing", name, joined(name, [*table[:5], [*table[5][:6], "999"], *table[6:]]))
    yield Case("two points of one id", name, joined(name, [*table, table[4]]))
    yield Case("a root alone", name, joined(name, [*table, ["900", "1", "9", "9", "9", "0.1", "-1"]]))
    yield Case("a cycle", name, joined(name, [*table, *([str(900 + k), "3", str(k), "9", str(k * k), "0.1", str(900 + (k + 1) % 3)] for k in range(3))]))
    yield Case("its own parent", name, joined(name, [*table, ["900", "3", "9", "9", "9", "0.1", "900"]]))
    yield Case("a cycle alone", name, joined(name, [[str(1 + k), "3", str(k), "9", "9", "0.1", str(1 + (k + 1) % 3)] for k in range(3)]))
    yield Case("no whole id", name, joined(name, [*table[:3], ["2.5", *table[3][1:]], *table[4:]]))
    yield Case("one point", name, b"1 1 0 0 0 1 -1\n")
    yield Case("points in any order", name, joined(name, [table[0], *table[:0:-1]]), refused=False)


def arrays():
    all_curves = list(curves())
    return {"points": numpy.concatenate(all_curves), "offsets": numpy.concatenate([[0], numpy.cumsum([len(c) for c in all_curves])]),
            "radii": numpy.full(sum(map(len, all_curves)), 0.011)}


def packed(name, given):
    out = io.BytesIO()
    if name.endswith(".npz"):
        numpy.savez(out, **given)
    elif name.endswith(".npy"):
        numpy.save(out, given["points"], allow_pickle=True)
    else:
        with h5py.File(out, "w") as file:
            for key, values in given.items():
                file[key] = values
    return out.getvalue()


def changes():
    """Arrays that are wrong."""
    good = arrays()
    points, offsets, radii = good["points"], good["offsets"], good["radii"]

    def of(array, index, value, **others):
        array = array.astype(float)
        array[index] = value
        return array

    yield "no offsets", {"points": points, "radii": radii}
    yield "points of two numbers", good | {"points": points[:, :2]}
    yield "points without a second dimension", good | {"points": points.ravel()}
    yield "no points at all", good | {"points": points[:0], "offsets": offsets[:1]}
    yield "radii of other points", good | {"radii": radii[:-1]}
    yield "radii of three numbers", good | {"radii": points}
    yield "offsets from 1", good | {"offsets": of(offsets, 0, 1)}
    yield "offsets beyond the points", good | {"offsets": of(offsets, -1, 99)}
    yield "offsets that fall", good | {"offsets": of(offsets, 2, 1)}
    yield "offsets between points", good | {"offsets": of(offsets, 2, 7.5)}
    yield "offsets of no number", good | {"offsets": of(offsets, 2, numpy.nan)}
    yield "a huge offset", good | {"offsets": of(offsets, 2, 1e300)}
    yield "a rod without points", good | {"offsets": of(offsets, 2, offsets[1])}
    yield "a rod of one point", good | {"offsets": of(offsets, 2, offsets[1] + 1)}
    yield "an unknown name", good | {"wobble": radii}
    yield "normals of other points", good | {"normals": points[1:]}
    yield "a normal of other rods", good | {"normal": points}
    yield "normal and normals", good | {"normal": numpy.ones((RODS, 3)), "normals": points}
    yield "nodes beside points", good | {"nodes": numpy.ones((RODS, 7, 3))}
    yield "texts", good | {"radii": numpy.array([b"a"] * len(radii))}
    yield "complex numbers", good | {"points": points.astype(complex)}
    yield "half precision", good | {"points": points.astype(numpy.float16)}
    for value in (numpy.nan, numpy.inf, 1e300):
        for row in (0, 13, -1):
            yield f"{value} in point {row}", good | {"points": of(points, (row, 1), value)}
    for value in (numpy.nan, -0.01, 0.0, 1e-200):
        yield f"a radius of {value}", good | {"radii": of(radii, 7, value)}
    yield "a point twice", good | {"points": of(points, 7, points[6])}


def array_cases():
    random = numpy.random.default_rng(5)
    equal = numpy.stack([curve[:5] for curve in curves()])
    for name in ("rods.npz", "rods.h5"):
        good = packed(name, arrays())
        yield Case("as it is", name, good, sound=True)
        yield Case("big endian", name, packed(name, {key: a.astype(a.dtype.newbyteorder(">")) for key, a in arrays().items()}), sound=True)
        yield Case("small integers", name, packed(name, arrays() | {"offsets": arrays()["offsets"].astype(numpy.uint8)}), sound=True)
        for title, given in changes():
            yield Case(title, name, packed(name, given))
        for size in (0.0, 0.1, 0.5, 0.9, 0.99):
            yield Case(f"cut at {size}", name, good[:int(size * len(good))])
        for trial in range(4):
            flipped = numpy.frombuffer(good, numpy.uint8).copy()
            flipped[random.integers(0, len(flipped), 4)] ^= 0x55
            yield Case(f"four bytes flipped, trial {trial}", name, flipped.tobytes(), refused=False)
            yield Case(f"noise, trial {trial}", name, random.integers(0, 256, 3000).astype(numpy.uint8).tobytes())
    whole = packed("rods.npy", {"points": equal})
    yield Case("as it is", "rods.npy", whole, sound=True)
    yield Case("objects", "rods.npy", packed("rods.npy", {"points": numpy.array(list(curves()), dtype=object)}))
    yield Case("objects", "rods.npz", packed("rods.npz", arrays() | {"radii": numpy.array([None] * 3, dtype=object)}))
    yield Case("records", "rods.npy", packed("rods.npy", {"points": numpy.zeros(4, dtype=[("x", "f8"), ("y", "f8")])}))
    yield Case("Fortran's order", "rods.npy", packed("rods.npy", {"points": numpy.asfortranarray(equal)}))
    yield Case("two dimensions", "rods.npy", packed("rods.npy", {"points": equal[0]}))
    yield Case("a scalar", "rods.npy", packed("rods.npy", {"points": numpy.float64(3.0)}))
    yield Case("no rods", "rods.npy", packed("rods.npy", {"points": equal[:0]}))
    yield Case("rods of one point", "rods.npy", packed("rods.npy", {"points": equal[:, :1]}))
    yield Case("rods of no points", "rods.npy", packed("rods.npy", {"points": equal[:, :0]}))
    yield Case("cut", "rods.npy", whole[:-8])
    yield Case("cut in its header", "rods.npy", whole[:40])
    yield Case("a huge shape", "rods.npy", whole.replace(b"(5, 5, 3)", b"(9223372036854775807, 5, 3)"))
    yield Case("a negative shape", "rods.npy", whole.replace(b"(5, 5, 3)", b"(-5,5, 3)"))
    yield Case("a shape of no numbers", "rods.npy", whole.replace(b"(5, 5, 3)", b"(x, 5, 3)"))
    compressed = io.BytesIO()
    numpy.savez_compressed(compressed, **arrays())
    packed_well = compressed.getvalue()
    yield Case("compressed", "rods.npz", packed_well, sound=True)
    for size in (0.2, 0.6, 0.95):
        yield Case(f"compressed, cut at {size}", "rods.npz", packed_well[:int(size * len(packed_well))])
    for at in (80, 120, 200, 300):  # in the data of the first array: the sum of its bytes tells
        flipped = bytearray(packed_well)
        flipped[at] ^= 0x10
        yield Case(f"compressed, byte {at} flipped", "rods.npz", bytes(flipped))
    bomb = bytearray(packed_well)
    at = bomb.find(b"PK\x01\x02") + 24
    bomb[at:at + 4] = b"\xf0\xff\xff\xff"
    yield Case("compressed, of 4 GB by its list", "rods.npz", bytes(bomb))
    strange = io.BytesIO()
    with zipfile.ZipFile(strange, "w") as archive:
        archive.writestr("points.npy", b"no array")
    yield Case("an archive of something else", "rods.npz", strange.getvalue())
    for trial in range(6):
        flipped = numpy.frombuffer(whole, numpy.uint8).copy()
        flipped[random.integers(0, 128, 2)] ^= 0x15
        yield Case(f"two bytes of the header flipped, trial {trial}", "rods.npy", flipped.tobytes(), refused=False)


def yarns(closed=(), counts=None, head=b"BCC\x44C0\x03\x02", curves_of=None, points_of=None, more=b"", rods=None):
    """A binary curve collection: numbers of closed curves, and what its header and its counts say where they are wrong."""
    rods = [numpy.asarray(c, "<f4") for c in (curves() if rods is None else rods)]
    own = [len(c) for c in rods] if counts is None else counts
    header = head + struct.pack("<QQ40s", len(rods) if curves_of is None else curves_of, sum(map(len, rods)) if points_of is None else points_of, b"a test")
    return header + b"".join(struct.pack("<i", -n if k in closed else n) + c.tobytes() for k, (n, c) in enumerate(zip(own, rods))) + more


def yarn_cases():
    random = numpy.random.default_rng(7)
    name, good = "yarns.bcc", yarns()
    yield Case("as it is", name, good, sound=True)
    yield Case("other curves through their points", name, yarns(head=b"BCC\x44C1\x03\x01"), sound=True)
    for title, head in (("another signature", b"BCD\x44C0\x03\x02"), ("floats of 8 bytes", b"BCC\x48C0\x03\x02"), ("curves beside their points", b"BCC\x44B0\x03\x02"),
                        ("2 dimensions", b"BCC\x44C0\x02\x02"), ("no type", b"BCC\x44\0\0\x03\x02")):
        yield Case(title, name, yarns(head=head))
    for many in (0, 4, 6, 2**31, 2**63, 2**64 - 1):
        yield Case(f"{many} curves", name, yarns(curves_of=many))
        yield Case(f"{many} points", name, yarns(points_of=many))
    for count in (0, 1, 4, 6, 2**31 - 1, -2**31, -5):
        yield Case(f"a count of {count}", name, yarns(counts=[count, 6, 7, 8, 9]))
    yield Case("closed curves", name, yarns(closed=(1, 3)))
    yield Case("bytes behind", name, yarns(more=b"\0\0\0\0"))
    yield Case("one point", name, yarns(rods=[[[1, 2, 3]]]))
    yield Case("a point twice", name, yarns(rods=[[[1, 2, 3], [1, 2, 3], [2, 2, 3]]]))
    for value in (numpy.nan, numpy.inf, 3e38):
        yield Case(f"{value} in a point", name, yarns(rods=[[[1, 2, 3], [1, value, 3], [2, 2, 3]]]))
    for size in (0, 3, 40, 63, 64, 66, 0.5, 0.9, len(good) - 1):
        yield Case(f"cut at {size}", name, good[:size if isinstance(size, int) else int(size * len(good))])
    for trial in range(6):
        flipped = numpy.frombuffer(good, numpy.uint8).copy()
        flipped[random.integers(0, len(flipped), 3)] ^= 0x55
        yield Case(f"three bytes flipped, trial {trial}", name, flipped.tobytes(), refused=False)
        yield Case(f"noise, trial {trial}", name, random.integers(0, 256, 3000).astype(numpy.uint8).tobytes())


class HostileRods(DriverTest):
    def check(self, case):
        (self.directory / case.name).write_bytes(case.data)
        self.scene.write_text(SCENE.format(name=case.name))
        return subprocess.run([SKEIN, "check", str(self.scene), "--json"], capture_output=True, text=True, errors="replace", timeout=60)

    def test_every_case_has_a_message_or_runs(self):
        cases = [*text_cases(), *array_cases(), *yarn_cases()]
        self.assertGreaterEqual(len(cases), LEAST)
        sound, refused = {}, 0
        for case in cases:
            with self.subTest(f"{case.name}: {case.title}"):
                done = self.check(case)
                told = f"code {done.returncode}: {done.stderr.strip()[:400]}"
                if done.returncode == 0:
                    self.assertFalse(case.refused, "it is read in silence")
                    step = json.loads(done.stdout)["dt_s"]
                    if case.sound:  # the first case of each name is the file as it is
                        self.assertEqual(step, sound.setdefault(case.name, step))
                    continue
                self.assertFalse(case.sound, told)
                self.assertEqual(done.returncode, 2, told)
                self.assertRegex(done.stderr, r"\Aerror: [^\n]*\n(  see docs/\S+\n)?\Z", told)
                self.assertIn(case.name, done.stderr)
                self.assertRegex(done.stderr, PLACE, told)
                refused += 1
        self.assertGreater(refused, 0.7 * len(cases))


if __name__ == "__main__":
    unittest.main()
