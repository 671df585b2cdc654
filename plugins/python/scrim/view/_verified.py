# SPDX-License-Identifier: Apache-2.0
"""The pixels that a verification compared with brute force, for the page: their places, and their errors beside the
error that the picture promises."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ._controls import promise_of

_NO_PROMISE = 0.01  # the error that stands for the promise of a scene that sets its dials by hand


def verified(frame: object, scene: Mapping, resolution: tuple[int, int]) -> dict:
    """`frame`: a `scrim.Frame` with `examined`. Returns a dict:

    `promise`: the error that the scene promises, else _NO_PROMISE. `states`: whether the scene promises an error.
    `pixels`: [x, y, picture, truth, error] of each compared pixel in the display window, largest error first.
    `picture` and `truth` are red, green and blue.

        error = sqrt(mean over r, g, b of (picture - truth)^2) / (mean of the reference)

    Where that mean is 0, the reference is black, and alpha takes the place of the colours:

        error = |alpha of picture - alpha of truth| / (mean alpha of the reference over the compared pixels)
    """
    examined, stats = frame.examined, frame.stats["verification"]
    picture, truth = examined["picture"], examined["truth"]
    off, mean = np.sqrt(np.mean((picture - truth)[:, :3] ** 2, axis=1)), stats["mean"]
    if mean <= 0:
        off, mean = np.abs(picture - truth)[:, 3], float(truth[:, 3].mean()) if len(truth) else 0.0
    errors = off / mean if mean > 0 else off
    inside = ((examined["place"] >= 0) & (examined["place"] < np.array(resolution))).all(axis=1)
    promise = promise_of(scene)
    pixels = [
        [*(int(v) for v in examined["place"][i]), _short(picture[i, :3]), _short(truth[i, :3]), _short(errors[i])]
        for i in np.argsort(-errors, kind="stable")
        if inside[i]
    ]
    return {"promise": promise or _NO_PROMISE, "states": promise is not None, "pixels": pixels}


def _short(value: np.ndarray) -> object:
    if value.ndim:
        return [_short(part) for part in value]
    return float(f"{value:.4g}") if np.isfinite(value) else 1e30
