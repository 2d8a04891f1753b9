"""Which share of each pixel of a picture is the object: by its alpha, in a mask, or against the background.

The background is a smooth surface of colours, fitted to the rim of the picture and then to all that looks
like it. A pixel counts by its distance from that, measured in the background's own scatter: so a grain or
light that changes slowly is near, another colour far. Otsu's threshold (IEEE Trans. SMC 9, 1979) parts the
two, and a graph cut (GrabCut, ACM Trans. Graphics 23, 2004) mends that by all colours of either side. The rim
of the object is then put where the distance is half that of the object next to it, so that a bright and a
dark part of one object end equally sharp.
"""

from dataclasses import dataclass

import cv2
import numpy as np

Array = np.ndarray

LEVELS = 40
"""Grey values nearer than this to black or white are black or white in a mask."""
FLOOR = 4.0
"""Scatter of the background that is taken for granted (of 255)."""
RIM = 0.04
"""Width of the rim that shows the background, over the picture's smaller side."""
CLEAR = 5.0
"""The object must be so far from the background (scatters), at least."""
UNLIKE = 2.5
"""What is nearer is background for a start (scatters)."""
CUT_ON = 600
"""Longer side of the picture on which the graph is cut (px)."""
SMOOTHED = 8.0
"""Distances are smoothed by this (px), over how far the object is from the background (scatters)."""
SMALLEST, LARGEST = 0.002, 0.95
"""Share of the picture that an object may cover."""


class NotFoundError(ValueError):
    """Nothing stands out from the background."""


@dataclass(frozen=True)
class Foreground:
    """What stands out."""

    coverage: Array
    """`(H, W)` in [0, 1]."""
    said: str
    """How it was found, for the user."""
    blur: float = 0.0
    """By how much its rim was smoothed against noise (px)."""
    cropped: bool = False
    """Whether it may reach the rim of the picture: there is nothing beyond."""


def by_alpha(alpha: Array | None) -> Foreground | None:
    """What is not transparent; None where all or nothing is."""
    if alpha is None or alpha.max() < 128 or alpha.min() >= 128:
        return None
    return Foreground(_smooth(alpha / 255.0), "the object is what is not transparent", cropped=True)


def by_two_levels(image: Array) -> Foreground | None:
    """Black on white or white on black, whichever the rim is not; None where other colours are there too."""
    dark, bright = image.max(axis=2) <= LEVELS, image.min(axis=2) >= 255 - LEVELS
    if np.mean(dark | bright) < 0.97 or not (dark.any() and bright.any()):
        return None
    rim = np.concatenate([bright[0], bright[-1], bright[:, 0], bright[:, -1]])
    share = image.mean(axis=2) / 255.0
    white = bool(rim.mean() > 0.5)
    said = f"a mask, {'black on white' if white else 'white on black'}"
    return Foreground(_smooth(1 - share if white else share), said, cropped=True)


def by_background(image: Array, taken: Array) -> Foreground:
    """What differs from the colours at the rim.

    Args:
        image: RGB `(H, W, 3)` uint8.
        taken: pixels that are not the object, such as a marker `(H, W)` bool.

    Raises:
        NotFoundError: nothing differs clearly, or nearly all does.
    """
    distance = _distance(image.astype(np.float32), taken)
    distance[taken] = 0
    rough = _without(_parted(image, distance, taken), taken)
    share = float(rough.mean())
    inside = float(np.median(distance[rough > 0])) if rough.any() else 0.0
    if inside < CLEAR or share < SMALLEST:
        raise NotFoundError("nothing in it stands out from the colours at its rim; take another background")
    if share > LARGEST:
        raise NotFoundError("the object fills it; leave room around the object")
    colour = ", ".join(f"{value:.0f}" for value in np.median(image[_rim(taken)], axis=0))
    said = f"the object is what differs from the rim (RGB {colour}), {inside:.0f} times its scatter"
    # The fainter it is, the more its rim must be smoothed against noise, which blunts its tips.
    blur = min(1.2, SMOOTHED / inside)
    distance = cv2.GaussianBlur(distance, (0, 0), blur)
    return Foreground(_half_way(distance, rough), said, blur)


def _parted(image: Array, distance: Array, taken: Array) -> Array:
    """The object, about `(H, W)` uint8: Otsu's threshold, then a graph cut on a smaller picture."""
    logs = np.log1p(distance)
    top = max(float(np.percentile(logs[~taken], 99.5)), 1e-6)
    scaled = np.clip(logs * (255 / top), 0, 255).astype(np.uint8)
    level, _ = cv2.threshold(scaled[~taken].reshape(-1, 1), 0, 255, cv2.THRESH_OTSU)
    likely = ((scaled > level) & (distance > UNLIKE)).astype(np.uint8)
    size = (np.array(taken.shape[::-1]) * min(1.0, CUT_ON / max(taken.shape))).round().astype(int).tolist()
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    likely = cv2.resize(likely, size, interpolation=cv2.INTER_AREA)
    never = cv2.resize((_rim(taken) & (distance < CLEAR) | taken).astype(np.uint8), size) > 0
    kinds = np.where(likely, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    kinds[never] = cv2.GC_BGD
    if np.isin(kinds, (cv2.GC_FGD, cv2.GC_PR_FGD)).sum() < 20:
        return np.zeros(taken.shape, np.uint8)
    cv2.setRNGSeed(0)  # its clusters of colours begin at random
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(small, kinds, (0, 0, 1, 1), *models, 4, cv2.GC_INIT_WITH_MASK)  # no rectangle is asked for
    found = np.isin(kinds, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.float32)
    return (cv2.resize(found, taken.shape[::-1], interpolation=cv2.INTER_LINEAR) > 0.5).astype(np.uint8)


def _distance(image: Array, taken: Array) -> Array:
    """Distance of every pixel from the background, in the background's scatter `(H, W)`."""
    height, width = taken.shape
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    x, y = x / width - 0.5, y / height - 0.5
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    step = max(1, round(np.sqrt(height * width / 60_000)))
    few, colours, free = terms[::step, ::step], image[::step, ::step], ~taken[::step, ::step]
    known = _rim(taken)[::step, ::step]
    distance = np.zeros(known.shape)
    for round_ in range(6):
        fit, *_ = np.linalg.lstsq(few[known], colours[known], rcond=None)
        off = colours - few @ fit
        scatter = np.cov(off[known].T) + FLOOR**2 * np.eye(3)
        distance = _norm(off, scatter)
        # At first from the rim alone, half of which may be something else; then from all that is like it.
        near = np.median(distance[known]) * 2.5 + 0.5
        known = free & (distance < max(near, 2.5)) & (known | (round_ >= 2))
        if known.sum() < 50:
            raise NotFoundError("its rim has no colour of its own; take a plain background")
    return np.asarray(_norm(image - terms @ fit.astype(np.float32), scatter), np.float32)


def _norm(off: Array, scatter: Array) -> Array:
    white = np.linalg.inv(np.linalg.cholesky(scatter)).astype(np.float32)
    return np.asarray(np.linalg.norm(off @ white.T, axis=-1))


def _rim(taken: Array) -> Array:
    width = max(2, round(RIM * min(taken.shape)))
    rim = ~taken
    rim[width:-width, width:-width] = False
    return np.asarray(rim)


def _without(rough: Array, taken: Array) -> Array:
    """Blobs that touch what is taken are left out: the paper on which a marker is printed."""
    if not taken.any():
        return rough
    _, labels = cv2.connectedComponents(rough, connectivity=8)
    near = cv2.dilate(taken.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return np.where(np.isin(labels, np.unique(labels[near])), 0, rough).astype(np.uint8)


def _half_way(distance: Array, rough: Array) -> Array:
    """Coverage in a band along a rough rim: where distances are between those inside and those outside."""
    band = max(4, round(0.005 * max(rough.shape)))
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * band + 1, 2 * band + 1))
    inside, outside = cv2.erode(rough, kernel), 1 - cv2.dilate(rough, kernel)
    reach = 1.5 * band
    within, without = _local(distance, inside, reach), _local(distance, outside, reach)
    coverage = (distance - without) / np.maximum(within - without, 1.0)
    coverage = np.where(inside > 0, 1.0, np.where(outside > 0, 0.0, coverage))
    thin = cv2.dilate(inside, kernel) < rough  # parts with no inside of their own
    return np.where(thin, np.maximum(coverage, rough * 0.75), coverage).clip(0, 1)


def _local(values: Array, where: Array, reach: float) -> Array:
    """Mean of values around each pixel, over the pixels that count."""
    weight = cv2.GaussianBlur(where.astype(np.float32), (0, 0), reach)
    total = cv2.GaussianBlur(values * where.astype(np.float32), (0, 0), reach)
    overall = float(values[where > 0].mean()) if where.any() else 0.0
    return np.where(weight > 1e-3, total / np.maximum(weight, 1e-3), overall)


def _smooth(share: Array) -> Array:
    """A mask without steps of whole pixels."""
    return cv2.GaussianBlur(share.astype(np.float32), (0, 0), 0.7)
