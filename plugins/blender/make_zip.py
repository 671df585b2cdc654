#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""make_zip.py FILE.zip: the add-on as Blender installs it, with the kit that all front ends share."""
import os
import sys
import zipfile

HERE = os.path.dirname(os.path.realpath(__file__))
FOLDERS = {"scrim": os.path.join(HERE, "scrim"), "scrim/scrim_kit": os.path.join(HERE, "..", "kit", "scrim_kit")}
DATE = (2020, 1, 1, 0, 0, 0)  # the same sources make the same file


def make_zip(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for inside, folder in FOLDERS.items():
            for name in sorted(os.listdir(folder)):
                if name.endswith((".py", ".toml")):
                    entry = zipfile.ZipInfo(f"{inside}/{name}", DATE)
                    entry.external_attr = 0o644 << 16  # the rights of a file
                    with open(os.path.join(folder, name), "rb") as file:
                        out.writestr(entry, file.read(), zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: make_zip.py FILE.zip")
    make_zip(sys.argv[1])
