"""One colour for each quantity, the same in the recording, the figures and the reports; errors: `task.TERMS`.

The hues are those of Okabe and Ito ("Color Universal Design", 2008), told apart with any colour vision and on
a dark or a white ground; the ramps are monotone in lightness, so they also survive a grey print.
"""

import numpy as np

Colour = tuple[int, int, int]

KAPPA: Colour = (86, 180, 233)
D: Colour = (230, 159, 0)
XI: Colour = (204, 121, 167)
PEAK: Colour = (148, 103, 214)
BOUND: Colour = (150, 150, 150)
STOP: Colour = (150, 150, 150)
LABEL: Colour = (130, 130, 130)
"""Text in the viewer, as far from its dark ground as from its light one."""

OBJECT: Colour = (66, 110, 200)
GOAL: Colour = (240, 200, 20)
CONTOUR: Colour = (20, 30, 70)
TRAIL: Colour = (120, 120, 120)
NEXT_PUSH: Colour = (215, 25, 28)
FORECAST: Colour = (0, 158, 115)
TABLE: Colour = (205, 205, 200)
TOOL: Colour = (140, 140, 145)
INK: Colour = (28, 30, 34)
"""Text on a picture."""

PAGE: dict[str, tuple[Colour, Colour]] = {
    "ground": ((252, 252, 250), (22, 24, 28)),
    "panel": ((255, 255, 255), (31, 34, 39)),
    "ink": ((28, 30, 34), (232, 232, 228)),
    "muted": ((96, 100, 106), (160, 164, 170)),
    "rule": ((222, 222, 218), (62, 66, 72)),
}
"""Colours of a page in a browser: on a light ground, on a dark one."""

PHASES: dict[str, Colour] = {"initial": (175, 175, 175), "exploit": (50, 110, 170), "explore": (225, 105, 30)}

RUNS: tuple[Colour, ...] = (
    (112, 102, 212),
    (238, 119, 51),
    (68, 170, 153),
    (136, 34, 85),
    (51, 187, 238),
    (140, 86, 60),
)
"""Runs or variants laid over each other, where a colour means no quantity: apart with any colour vision."""

RAMP: tuple[Colour, ...] = ((250, 250, 245), (170, 215, 205), (90, 170, 170), (35, 115, 130))
"""From little to much of what deserves a look; light enough for black marks: sigma, promise."""
CLOSED: Colour = (150, 150, 154)
"""On a map of the acquisition, where no push is allowed."""
ALONG: tuple[Colour, ...] = ((13, 8, 135), (126, 3, 168), (204, 71, 120), (245, 145, 60))
"""kappa from 0 to 1 along the contour; every colour stands out on white."""
BALANCE: tuple[Colour, ...] = ((0, 90, 160), (120, 175, 215), (245, 245, 245), (240, 170, 100), (180, 70, 0))
"""From negative through zero to positive: the change of error, blue where it falls."""
STRAIN: tuple[Colour, ...] = (OBJECT, (150, 170, 225), (255, 244, 220))
"""From unstrained, in the object's own colour, to strained as much as it may be."""
HARM: Colour = (160, 0, 70)
"""Strained beyond the limit: far darker than the pale colour just below it."""


def ramp(values: np.ndarray, colours: tuple[Colour, ...] = RAMP) -> np.ndarray:
    """Colours `(..., 3)` uint8 of values `(...)` in [0, 1]; values beyond take the colour of the end."""
    at = np.linspace(0, 1, len(colours))
    channels = [np.interp(values, at, channel) for channel in zip(*colours, strict=True)]
    return np.round(np.stack(channels, -1)).astype(np.uint8)


def lighter(colour: Colour, share: float = 0.5) -> Colour:
    """Mix a colour with white: a band or bound that belongs to the line of this colour."""
    r, g, b = (round(c + (255 - c) * share) for c in colour)
    return r, g, b


def unit(colour: Colour) -> tuple[float, float, float]:
    """The colour as matplotlib wants it, each channel in [0, 1]."""
    r, g, b = colour
    return r / 255, g / 255, b / 255
