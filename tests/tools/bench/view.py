# SPDX-License-Identifier: Apache-2.0
"""Measures the viewer in a headless Chromium without a graphics unit, and prints a table.

    python view.py SCENE.toml [PICTURE.jpg]

Needs the package scrim, tornado, tomlkit, playwright and chromium. Every time is from an event in the page to the
screen: to the first animation frame after the one that drew its picture. PICTURE: where a picture of the page goes.
"""

import statistics
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "examples"))
from viewer import chromium_of, viewer_of  # noqa: E402

PATIENCE = 300_000  # milliseconds
EVENTS = 60
# The sum of the differences of neighbouring pixels.
DETAIL = """() => {
    const pixels = scrim.readPixels();
    let sum = 0;
    for (let i = 4; i < pixels.length; ++i) sum += Math.abs(pixels[i] - pixels[i - 4]);
    return sum;
}"""


def described(name, times, seconds):
    """A row: how many pictures, how many a second, median and 90 % of their times in milliseconds."""
    times = sorted(times)
    if not times:
        return f"{name:<28} nothing was shown"
    late = times[min(int(0.9 * len(times)), len(times) - 1)]
    middle = statistics.median(times)
    rate = len(times) / seconds
    return f"{name:<28} {len(times):4d} shown, {rate:5.1f}/s, median {middle:5.0f} ms, 90 % {late:5.0f} ms"


def drag(page, start, steps, kind):
    """Drags from `start` by `steps`; the times that the page noted, and the seconds that it took."""
    page.evaluate(f"scrim.times.{kind}.length = 0")
    page.mouse.move(*start)
    page.mouse.down()
    began = time.monotonic()
    for number in range(EVENTS):
        page.mouse.move(start[0] + steps[0] * number, start[1] + steps[1] * number)
        time.sleep(1 / 60)
    seconds = time.monotonic() - began
    times = page.evaluate(f"[...scrim.times.{kind}]")
    page.mouse.up()
    return times, seconds


def detail_of_turn(page, start, degrees):
    """The detail of the picture that is shown during a turn, over that of the finished one."""
    height = page.locator("#picture").bounding_box()["height"]
    page.mouse.move(*start)
    page.mouse.down()
    for number in range(1, EVENTS + 1):
        page.mouse.move(start[0] + degrees / 180 * height * number / EVENTS, start[1])
    moving = page.evaluate(DETAIL)
    page.mouse.up()
    exact(page)
    return moving / page.evaluate(DETAIL)


def exact(page):
    """Waits for the picture of the scene's file, and for the layers behind it."""
    done = "scrim.isSettled && document.body.dataset.stage === 'exact' && document.body.dataset.layers"
    page.wait_for_function(done, timeout=PATIENCE)


def measure(page, url, began):
    page.goto(url)
    page.wait_for_function("document.body.dataset.stage", timeout=PATIENCE)
    print(f"{'first picture':<28} {time.monotonic() - began:.2f} s after the command, in a browser that runs")
    exact(page)
    box = page.locator("#picture").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    print(described("orbit: its picture", *drag(page, middle, (2, 1), "picture")))
    page.wait_for_timeout(3000)
    print(described("orbit: the view", *drag(page, middle, (-2, -1), "view")))
    began = time.monotonic()
    page.wait_for_function("document.body.dataset.stage === 'final' || document.body.dataset.stage === 'exact'",
                           timeout=PATIENCE)  # fmt: skip
    print(f"{'at rest, as the scene asks':<28} {time.monotonic() - began:.2f} s after the mouse was let go")
    exact(page)
    for degrees in (3, 7, 15, 30):
        print(f"{f'a turn by {degrees} degrees':<28} {100 * detail_of_turn(page, middle, degrees):.0f} % of the detail")
    slider = page.locator("input[type=range]").first.bounding_box()
    start = (slider["x"] + slider["width"] / 2, slider["y"] + slider["height"] / 2)
    print(described("intensity of a light", *drag(page, start, (0.5, 0), "weights")))
    exact(page)
    slider = page.get_by_label("azimuth", exact=False).first.bounding_box()
    start = (slider["x"] + slider["width"] / 2, slider["y"] + slider["height"] / 2)
    print(described("azimuth of a light", *drag(page, start, (0.5, 0), "picture")))
    exact(page)


def main(scene, picture=None):
    with sync_playwright() as kit:
        chromium = chromium_of(kit)
        page = chromium.new_page(bypass_csp=True, viewport={"width": 1280, "height": 760})
        began = time.monotonic()
        with viewer_of(scene) as url:
            print(f"{'listening':<28} {time.monotonic() - began:.2f} s after the command")
            measure(page, url, began)
            if picture:
                page.screenshot(path=picture, type="jpeg", quality=88)
        chromium.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
