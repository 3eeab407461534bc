"""Damaged checkpoints are named and passed by, or the damage touched nothing that is read: the end has the bits of the whole run, or
the run is refused."""

import collections
import shutil
import unittest

import h5py

from faults import ALL, FREE, TOUCHING, FaultTest

STOPS = (700, 1000, 1300)  # a run in three parts; the last is computed again from damaged files


def stored_numbers(path):
    """Where the file's datasets lie: [(first byte, bytes)]; the rest is what HDF5 keeps about them, attributes too."""
    found = []

    def look(_, item):
        if isinstance(item, h5py.Dataset) and item.id.get_offset() is not None:
            found.append((item.id.get_offset(), item.id.get_storage_size()))

    with h5py.File(path) as file:
        file.visititems(look)
    return found


class Damage(FaultTest):
    def prepare(self):
        self.KEYS = ("--set", "output.trajectory=0", "--set", "output.tips=0", "--set", "output.checkpoint=0", "--set", "output.keep=3",
                     "--set", "output.audit=true")
        self.run_to_end("whole", "--steps", str(STOPS[2]))
        for stop in STOPS[:2]:
            self.run_to_end("parts", "--steps", str(stop))
        self.assertEqual(len(self.checkpoints("parts")), 2)

    def rows_of(self, out):
        """Step and time of each; the last bits of some columns depend on the number of ranks."""
        return [row.split(",")[:2] for row in (self.directory / out / "observables.csv").read_text().splitlines()]

    def resume(self, damage, ranks):
        """Goes on from a copy whose newest checkpoint `damage` has changed: 'refused' or 'unharmed'."""
        shutil.rmtree(self.directory / "out", ignore_errors=True)
        shutil.copytree(self.directory / "parts", self.directory / "out")
        older, newest = self.checkpoints("out")
        newest.write_bytes(damage(newest.read_bytes()))
        told, errors = self.run_to_end("out", "--steps", str(STOPS[2]), ranks=ranks)
        self.assertEqual(self.digest("out"), self.digest("whole"), told + errors)
        self.assertEqual(self.rows_of("out"), self.rows_of("whole"))
        if f"Resuming from {newest}" in told:
            self.assertNotIn("warning: " + str(newest), errors)
            return "unharmed"
        self.assertIn(f"Resuming from {older}", told)
        lines = [line for line in errors.splitlines() if newest.name in line]
        self.assertEqual(len(lines), 1, errors)
        self.assertGreater(len(lines[0].split(newest.name)[1]), 10, "no reason is given")
        return "refused"

    def trials(self, name, count, damage):
        found = collections.Counter(self.resume(damage, self.draw.choice((1, 1, 2, 3))) for _ in range(count))
        print(f"{name}: {count} damaged checkpoints: {found['refused']} named and passed by, {found['unharmed']} read, with the same bits")
        return found

    def scenes(self):
        for name, scene in (("rods that touch", TOUCHING), ("free rods", FREE)):
            shutil.rmtree(self.directory / "parts", ignore_errors=True)
            shutil.rmtree(self.directory / "whole", ignore_errors=True)
            self.scene.write_text(scene)
            self.prepare()
            yield name

    def test_truncated(self):
        for name in self.scenes():
            found = self.trials(f"truncated, {name}", 25 if ALL else 3, lambda content: content[: self.draw.randrange(len(content))])
            self.assertEqual(found["unharmed"], 0)

    def test_flipped_bytes(self):
        for name in self.scenes():
            numbers = stored_numbers(self.checkpoints("parts")[-1])
            inside = lambda at: any(begin <= at < begin + size for begin, size in numbers)

            def flip(in_numbers):
                def damage(content):
                    at = self.draw.choice([k for k in range(len(content)) if inside(k) == in_numbers])
                    return content[:at] + bytes([content[at] ^ self.draw.randrange(1, 256)]) + content[at + 1:]
                return damage

            found = self.trials(f"a byte of the numbers changed, {name}", 50 if ALL else 4, flip(True))
            self.assertEqual(found["unharmed"], 0)
            self.trials(f"a byte of the rest changed, {name}", 50 if ALL else 4, flip(False))

    def test_flipped_texts(self):
        """The scene and the settings, long texts that HDF5 keeps no checksums of."""
        self.prepare()
        for text in (b'"youngs_modulus"', b'"checkpoint_wall"'):
            def damage(content):
                self.assertEqual(content.count(text), 1 if text.endswith(b'wall"') else 2)
                return content.replace(text, text[:-2] + b'?"', 1)

            for ranks in (1, 2):
                self.assertEqual(self.resume(damage, ranks), "refused")

    def test_without_any_sound_checkpoint_a_run_is_refused(self):
        self.prepare()
        for path in self.checkpoints("parts"):
            path.write_bytes(path.read_bytes()[:5000])
        before = {path: path.read_bytes() for path in self.checkpoints("parts")}
        for ranks in (1, 3):
            errors = self.run_to_end("parts", "--steps", str(STOPS[2]), expect=5, ranks=ranks)[1]
            for path, content in before.items():
                self.assertIn(path.name, errors)
                self.assertEqual(path.read_bytes(), content, "a refused run changed files")
            self.assertIn("none of its 2 checkpoints can be read", errors)


if __name__ == "__main__":
    unittest.main()
