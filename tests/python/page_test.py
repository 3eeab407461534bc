"""skein draw --html: one file with everything in it, which a browser draws: rods where they are, at the time asked for."""

import base64
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import zlib

import numpy as np

from package import Directory, skein

from PIL import Image

BROWSER = shutil.which("chromium") or shutil.which("chromium-headless-shell") or shutil.which("google-chrome")
THREE = pathlib.Path("/usr/share/javascript/three/build/three.min.js").exists()
FLAGS = ("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--virtual-time-budget=6000")


@unittest.skipUnless(THREE, "three.js is not here (Debian: libjs-three)")
class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = Directory()
        cls.run_ = skein.open(cls.directory.out)
        cls.page = skein.page(cls.run_, cls.directory.path / "view.html", time=0.15)

    @classmethod
    def tearDownClass(cls):
        cls.directory.close()

    def test_one_file_that_needs_no_other(self):
        text = self.page.read_text()
        self.assertLess(len(text), 5e6)
        own = re.sub(r"(?s)<script>.*?</script>", "", text)
        for word in ("src=", "href=", "http:", "https:", "@import"):
            self.assertNotIn(word, own)

    def test_numbers_come_back(self):
        """Places to half a step of their sixteen bits."""
        text = self.page.read_text()
        scene = json.loads(re.search(r'(?s)id="scene" type="application/json">(.*?)</script>', text)[1])
        data = zlib.decompress(base64.b64decode(re.search(r'(?s)id="data" type="text/plain">(.*?)</script>', text)[1]))
        group, reeds = scene["groups"][0], self.run_["reeds"]
        count = scene["frames"] * group["rods"] * group["nodes"] * 3
        packed = np.frombuffer(data, np.uint16, count).reshape(scene["frames"], group["rods"], group["nodes"], 3)
        places = np.array(group["low"]) + np.array(group["step"]) * np.cumsum(packed, axis=0, dtype=np.uint16)
        self.assertEqual(scene["times"], self.run_.time.tolist())
        self.assertLess(np.abs(places - reeds.position[:]).max(), 0.51 * max(group["step"]))
        self.assertEqual(len(scene["bodies"]), 1)

    def test_as_many_frames_as_fit(self):
        from skein.picture import page
        before, page.BUDGET = page.BUDGET, 6000
        try:
            small = skein.page(self.run_, self.directory.path / "small.html")
        finally:
            page.BUDGET = before
        scene = json.loads(re.search(r'(?s)id="scene" type="application/json">(.*?)</script>', small.read_text())[1])
        self.assertLess(scene["frames"], len(self.run_.frames))
        self.assertEqual(scene["times"][-1], self.run_.time[-1])

    def test_title_of_evil(self):
        self.run_.summary["title"] = "</script><b>&"
        try:
            text = skein.page(self.run_, self.directory.path / "evil.html").read_text()
        finally:
            del self.run_.summary["title"]
        self.assertNotIn("</script><b>", text)

    @unittest.skipUnless(BROWSER, "there is no Chromium (Debian: chromium)")
    def test_in_a_browser(self):
        shot = self.directory.path / "shot.png"
        with tempfile.TemporaryDirectory() as profile:
            subprocess.run([BROWSER, *FLAGS, f"--user-data-dir={profile}", "--window-size=960,540", f"--screenshot={shot}", f"file://{self.page}"],
                           capture_output=True, timeout=150)
            said = subprocess.run([BROWSER, *FLAGS, f"--user-data-dir={profile}", "--dump-dom", f"file://{self.page}"], capture_output=True, text=True, timeout=150).stdout
        self.assertIn('data-state="drawn"', said)
        self.assertIn("150.00 ms", said)
        image = np.asarray(Image.open(shot).convert("RGB")).astype(int)
        drawn = image[60:-70]
        coloured = np.ptp(drawn, axis=2) > 40
        self.assertGreater(coloured.sum(), 2000, "rods have colours")
        self.assertLess(coloured.mean(), 0.5, "on white")
        rows, columns = np.nonzero(coloured)
        self.assertGreater(np.ptp(columns), 200)
        self.assertGreater(np.ptp(rows), 100)


if __name__ == "__main__":
    unittest.main()
