"""Scenes from Python: built, checked by the program itself, written as TOML (docs/scene.md has every key)."""

import subprocess
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from . import notebook
from .program import RunFailed, _toml, as_file, command, environment, lists, overrides

IN_TEXT = 32  # rods whose places are written into the scene; of more they go into an HDF5 file beside it
OF_FILE = {"origins": "origin", "directions": "tangent", "normals": "normal", "lengths": "length", "radii": "radius", "nodes": "nodes"}


class Scene:
    """A scene as a tree of keys, from nothing or from a file.

        scene = skein.Scene("filament", time={"duration": 2.0}, output={"trajectory": 0.05})
        scene.rods("filament", start="clamped", material={"density": 1200, "youngs_modulus": 2e6}, section={"radius": 3e-3},
                   shape={"length": 0.2, "elements": 30}, origins=points, directions=ways)
        scene.load("gravity")
        scene.check()
        skein.run(scene)

    scene["time.duration"] = 3.0 sets a key by its path; groups go by name, entries of other lists by number: scene["rods.filament.shape.elements"],
    scene["load.0.acceleration"].
    """

    def __init__(self, name="scene", **tables):
        self.name, self._tree, self._arrays = Path(name).stem, {}, {}
        if str(name).endswith(".toml"):
            import tomllib
            self._folder = Path(name).resolve().parent
            self._tree = tomllib.loads(Path(name).read_text())
        else:
            self._folder = None
        for key, value in tables.items():
            self._tree[key] = deepcopy(value)

    def __repr__(self):
        parts = []
        for table, value in self._tree.items():
            if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
                names = [f"'{entry['name']}'" if "name" in entry else str(entry.get("kind", "?")) for entry in value]
                parts.append(f"{table} {', '.join(names)}")
        duration = self._tree.get("time", {}).get("duration")
        return f"<Scene '{self.name}': {'; '.join(parts) or 'empty'}{f'; {duration:g} s' if isinstance(duration, (int, float)) else ''}>"

    def _repr_html_(self):
        """A row for each table: its keys, and of lists of tables a row for each entry."""
        rows = []
        for table, value in self._tree.items():
            entries = value if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value) else [value]
            for entry in entries:
                keys = {key: item for key, item in entry.items() if key != "name"} if isinstance(entry, dict) else None
                name = f"{table} {entry['name']}" if isinstance(entry, dict) and "name" in entry else table
                rows.append((name, ", ".join(f"{key} = {_toml(item)}" for key, item in keys.items()) if keys is not None else _toml(entry)))
        return notebook.table(self.name, rows)

    def rods(self, name, origins=None, directions=None, normals=None, lengths=None, radii=None, nodes=None, **keys):
        """Adds a group. Places as arrays: origins, directions (d3 at the start), normals (d1 there) [rods, 3], lengths, radii [rods], or whole centrelines, nodes
        [rods, elements + 1, 3]; keys: its tables, as in a file."""
        given = {"origins": origins, "directions": directions, "normals": normals, "lengths": lengths, "radii": radii, "nodes": nodes}
        given = {key: np.asarray(value, float) for key, value in given.items() if value is not None}
        counts = {key: len(value) for key, value in given.items()}
        if len(set(counts.values())) > 1:
            raise ValueError(f"group '{name}': places of unlike numbers of rods: " + ", ".join(f"{key} {count}" for key, count in counts.items()))
        entry = {"name": name, **deepcopy(keys)}
        if given:
            self._place(entry, given)
        self._tree.setdefault("rods", []).append(entry)
        return self

    def rods_from(self, name, curves, radii=None, normals=None, unit=1.0, voxel=None, **keys):
        """Adds a group of rods along centrelines: a list of arrays [points, 3], or one [rods, points, 3], which are resampled to shape.elements.

            scene.rods_from("filaments", traces, radii=0.2, unit=1e-6, material={...}, section={"radius": 2e-7}, shape={"length": 1e-5, "elements": 20})

        radii: one for all, one per rod, or one per point; normals: d1 at the start [rods, 3], or at each point; unit: length of 1 in the arrays, m; voxel:
        lengths of 1 in the points along x, y and z, m, where they differ. An HDF5 file beside the scene holds them.
        """
        from .centrelines import ragged
        points, offsets = ragged(curves)
        arrays = {"points": points, "offsets": offsets}
        if radii is not None:
            arrays["radii"] = ragged(curves, radii)
        if voxel is not None:
            arrays["voxel"] = np.broadcast_to(np.asarray(voxel, float), 3).copy()
        if normals is not None:
            at_start = np.ndim(normals[0]) == 1
            arrays["normal" if at_start else "normals"] = np.asarray(normals, float) if at_start else ragged(curves, normals, "normals", (3,))
        entry = {"name": name, **deepcopy(keys)}
        placement = entry.setdefault("placement", {})
        placement |= {"kind": "file", "file": f"{self.name}_{name}.h5"} | ({"unit": unit} if unit != 1.0 else {})
        self._arrays[placement["file"]] = arrays
        self._tree.setdefault("rods", []).append(entry)
        return self

    def _place(self, entry, given):
        plain = set(given) <= {"origins", "directions", "normals"}
        count = len(next(iter(given.values())))
        placement = entry.setdefault("placement", {})
        if plain and count <= IN_TEXT and "origins" in given:
            placement |= {"kind": "list", "origins": given["origins"].tolist()}
            placement |= {key: given[word].tolist() for word, key in (("directions", "tangents"), ("normals", "normals")) if word in given}
        else:
            placement |= {"kind": "file", "file": f"{self.name}_{entry['name']}.h5"}
            self._arrays[placement["file"]] = {OF_FILE[key]: value for key, value in given.items()}

    def load(self, kind, /, **keys):
        """Adds a [[load]]; `rods`: names of groups, else all."""
        return self.add("load", kind=kind, **keys)

    def damping(self, kind, /, **keys):
        return self.add("damping", kind=kind, **keys)

    def wall(self, name, kind, /, **keys):
        return self.add("wall", name=name, kind=kind, **keys)

    def table(self, name, at, value, **keys):
        """A function of time for formulas, piecewise linear through points; skein.Simulation can drive it on."""
        return self.add("table", name=name, at=np.asarray(at, float).tolist(), value=np.asarray(value, float).tolist(), **keys)

    def bodies(self, name, /, **keys):
        """Adds a group of rigid bodies: mass or density, parts, placement."""
        return self.add("bodies", name=name, **keys)

    def joint(self, kind, first, second="world", /, **keys):
        """Adds a [[joint]] between two groups, or of a group and the world; a motor's value may name a table, which skein.Simulation drives.

            scene.joint("hinge", "arm", axis=[0, 1, 0], at=[0.0], stiffness=1e5, torsional_stiffness=100.0,
                        motor={"kind": "position", "value": "angle(t)", "stiffness": 50.0})
        """
        return self.add("joint", kind=kind, between=[first, second], **keys)

    def assembly(self, name, /, **keys):
        """Adds an [[assembly]]: groups with assembly=name are copied together to its places."""
        return self.add("assembly", name=name, **keys)

    def stage(self, name, duration=None, until=None, change=(), **keys):
        """Adds a [[stage]] (docs/stages.md): it ends after `duration` [s], or where `until` holds; change: {path: value} from its begin on.

            scene.stage("fall", until="max_speed < 1e-3", check_every=0.05)
            scene.stage("press", duration=2.0, change={"wall.lid.velocity": [0, 0, -0.01]})
        """
        given = {"duration": duration, "until": until, "change": overrides(dict(change)) or None}
        return self.add("stage", name=name, **{key: value for key, value in given.items() if value is not None}, **keys)

    def add(self, table, /, **keys):
        """Appends an entry to any of the lists that the program knows: rods, bodies, load, joint, assembly, obstacle, fluid_output, ...

            scene.add("obstacle", kind="sphere", centre=[0, 0, 0], radius=0.1)
        """
        known = lists()
        if table not in known:
            near = get_close_matches(table, known, 1)
            raise KeyError(f"no list '{table}' in scenes; " + (f"did you mean '{near[0]}'?" if near else f"there are {', '.join(known)}"))
        self._tree.setdefault(table, []).append(deepcopy(keys))
        return self

    def _walk(self, path, make):
        *parents, last = path.split(".")
        place = self._tree
        for part in parents:
            if isinstance(place, list):
                place = self._entry(place, part, path)
            else:
                if part not in place and not make:
                    raise KeyError(f"no '{path}' in scene '{self.name}'")
                place = place.setdefault(part, {})
        return place, last

    @staticmethod
    def _entry(entries, part, path):
        for entry in entries:
            if entry.get("name") == part:
                return entry
        if part.isdigit() and int(part) < len(entries):
            return entries[int(part)]
        raise KeyError(f"no entry '{part}' for '{path}'; there are {', '.join(str(entry.get('name', k)) for k, entry in enumerate(entries))}")

    def __setitem__(self, path, value):
        place, last = self._walk(path, True)
        if isinstance(place, list):
            place[place.index(self._entry(place, last, path))] = value
        else:
            place[last] = value

    def __getitem__(self, path):
        place, last = self._walk(path, False)
        if isinstance(place, list):
            return self._entry(place, last, path)
        if last not in place:
            raise KeyError(f"no '{path}' in scene '{self.name}'; defaults are the program's: skein describe {path}")
        return place[last]

    def copy(self):
        return deepcopy(self)

    def text(self):
        """As TOML."""
        lines, lists = [], []
        for key, value in self._tree.items():
            if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
                lists += [_table(f"[[{key}]]", entry) for entry in value]
            elif isinstance(value, dict):
                lists.insert(0, _table(f"[{key}]", value))
            else:
                lines.append(f"{key} = {_toml(value)}")
        return "\n\n".join(["\n".join(lines)] * bool(lines) + lists) + "\n"

    def save(self, path=None):
        """Writes NAME.toml, or `path`, and files of places beside it; returns the path."""
        path = Path(path or f"{self.name}.toml")
        path.parent.mkdir(parents=True, exist_ok=True)
        for file, arrays in self._arrays.items():
            import h5py
            with h5py.File(path.parent / f"{file}.tmp", "w") as places:
                for key, values in arrays.items():
                    places[key] = values
            (path.parent / f"{file}.tmp").replace(path.parent / file)
        part = path.with_name(path.name + ".tmp")
        part.write_text(self.text())
        part.replace(path)
        self._folder = path.resolve().parent
        return path

    def written(self, folder):
        """Saves it into a folder of somebody else's, with the files that it names within reach; returns the path."""
        if self._folder:
            for file in self._files():
                if not Path(file).is_absolute() and (self._folder / file).exists() and file not in self._arrays:
                    (folder / file).parent.mkdir(parents=True, exist_ok=True)
                    (folder / file).symlink_to(self._folder / file)
        kept = self._folder
        path = self.save(folder / f"{self.name}.toml")
        self._folder = kept
        return path

    def _files(self):
        entries = [group.get("placement", {}) for key in ("rods", "bodies") for group in self._tree.get(key, [])] + self._tree.get("table", [])
        entries += [assembly.get("placement", {}) for assembly in self._tree.get("assembly", [])]
        return [entry["file"] for entry in entries if entry.get("file")] + self._tree.get("include", [])

    def check(self):
        """Raises RunFailed with all that the program finds wrong, each with the line of text() and the nearest valid key."""
        with as_file(self) as path:
            done = subprocess.run(command("check", path, {}), capture_output=True, text=True, env=environment())
        if done.returncode:
            raise RunFailed(done.stderr.strip().replace(str(path), path.name), done.returncode)
        return self


def _table(head, entries):
    """Scalars first, then tables within, in one line each."""
    plain = [f"{key} = {_toml(value)}" for key, value in entries.items() if not isinstance(value, dict)]
    return "\n".join([head, *plain, *(f"{key} = {_toml(value)}" for key, value in entries.items() if isinstance(value, dict))])
