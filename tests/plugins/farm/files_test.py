# SPDX-License-Identifier: Apache-2.0
"""Tiles of shots that write further files: each file of the whole is merged from its own tiles."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, HERE)
from job_tasks import SCENE, SCRIM, run_tasks, submit, task_commands, told  # noqa: E402

LIGHT = """[[light]]
name = "key"
type = "distant"
direction = [1, -1, -1]
"""
# The second file has less precision and layers that fill the whole window, the third one loses by compression, the
# fourth holds the picture, too.
OUTPUTS = """[[output]]
file = "out/p.####.exr"
type = "float"
deep = "out/deep.####.exr"
preview = "out/p.####.png"
[[output]]
file = "out/z.####.exr"
layers = ["depth", "transmittance"]
type = "half"
compression = "piz"
[[output]]
file = "out/l.####.exr"
layers = ["light"]
compression = "dwaa"
[[output]]
file = "out/m.####.exr"
layers = ["cryptomatte"]
picture = true
"""
FILES = [f"{name}.{frame:04}.exr" for name in ("p", "deep", "z", "l", "m") for frame in (1, 2)]


class FurtherFiles(unittest.TestCase):
    def setUp(self):
        temp = tempfile.TemporaryDirectory()
        self.addCleanup(temp.cleanup)
        self.place, self.job = temp.name, os.path.join(temp.name, "shot.farm")
        with open(os.path.join(self.place, "shot.toml"), "w", encoding="utf-8") as out:
            out.write(SCENE.replace("[32, 24]", "[96, 64]") + LIGHT + OUTPUTS)

    def path(self, *names):
        return os.path.join(self.place, *names)

    def submit(self):
        submit(self.place, "shot.toml", "--frames", "1-2", "--tiles", "2x2", "--chunk", "2")

    def as_a_whole(self):
        """That each file holds the bits of a render without a farm."""
        with open(os.path.join(self.job, "job.json"), encoding="utf-8") as text:
            arguments = json.load(text)["arguments"]  # what tasks were given
        told([SCRIM, "render", "shot.toml", "--frames", "1-2", *arguments, "-q", "-o", "plain/p.####.exr", "--deep",
              "plain/deep.####.exr", *(word for name in "zlm" for word in ("--file", f"plain/{name}.####.exr"))],
             self.place)
        for name in FILES:
            told([sys.executable, "-B", os.path.join(HERE, "same_chunks.py"), f"plain/{name}", f"out/{name}"],
                 self.place)

    def left(self):
        return [name for _, _, names in os.walk(os.path.join(self.job, "tiles")) for name in names]

    def test_each_has_the_bits_of_the_whole(self):
        self.submit()
        os.mkdir(self.path("plain"))
        self.assertIn("2 of 2 frames are complete", run_tasks(self.job, "1-2"))
        self.assertEqual(sorted(os.listdir(self.path("out"))), sorted([*FILES, "p.0001.png", "p.0002.png"]))
        self.assertEqual(self.left(), [])
        self.as_a_whole()

    def test_what_is_missing_or_stale_is_made_again(self):
        self.submit()
        os.mkdir(self.path("plain"))
        *renders, merge, check = task_commands(self.job, "1-2")
        for command in renders:
            told(command, self.place)
        tiles = os.path.join(self.job, "tiles")
        os.unlink(os.path.join(tiles, "0", "file2.000001.exr"))
        os.truncate(os.path.join(tiles, "3", "file4.000002.exr"), 500)
        done = subprocess.run(merge, capture_output=True, text=True, check=False, timeout=60, cwd=self.place)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("file2.000001.exr': there is no such file", done.stderr)
        for command in [*renders, merge]:
            told(command, self.place)
        os.unlink(self.path("out", "l.0002.exr"))  # with its tiles, which are removed by now
        for command in [*renders, merge]:
            told(command, self.place)
        self.assertIn("2 of 2 frames are complete", told(check, self.place))
        self.assertEqual(self.left(), [])
        self.as_a_whole()


if __name__ == "__main__":
    unittest.main()
