"""The effective contour: which part of the contour may be pushed, and how kappa runs along it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from deformpush.cell.observation import FirstLook, Observation
from deformpush.cell.ranges import Degrees, Point, Share
from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.rounding import lowest
from deformpush.mechanics.seam import point_towards

Array = np.ndarray

ORIGIN = np.zeros(2)


class Effective(ABC):
    """A part of the contour, counter-clockwise from a first to a last point."""

    @property
    @abstractmethod
    def closed(self) -> bool:
        """Whether it goes all the way round."""

    @abstractmethod
    def ends(self, look: FirstLook) -> tuple[int, int]:
        """Indices of the first and the last point of a contour in the object's frame."""

    def placed(self, start: Array, start_deg: float) -> "Effective":
        """The same for an object whose outline was put down at `start` `(2,)` (m), turned by `start_deg`."""
        del start, start_deg
        return self

    def indices(self, seen: Observation) -> Array:
        """Indices into the contour `(M_e,)` in the order of kappa; a closed one repeats its first point."""
        look = seen.reference
        first, last = self.ends(look if look.followed else FirstLook(seen.body, 1, seen.c, seen.theta))
        m = len(seen.contour)
        count = m if self.closed else (last - first) % m
        return (first + np.arange(count + 1)) % m


@dataclass(frozen=True)
class EffectiveContour(Effective):
    """Between two directions in the object's frame.

    It runs counter-clockwise from the contour point seen from the centroid under `first_deg` (measured from
    the principal direction) to the one under `last_deg`. 360 degrees apart means all the way round. On a
    contour that is not star-shaped the points are those that `deformpush.mechanics.seam` finds.
    """

    first_deg: Degrees
    last_deg: Degrees

    def __post_init__(self) -> None:
        if not 0 < self.last_deg - self.first_deg <= 360:
            raise ValueError(
                f"last_deg: {self.last_deg:g} gives an effective contour of zero or more than full length; "
                "it must lie in (first_deg, first_deg + 360] = "
                f"({self.first_deg:g}, {self.first_deg + 360:g}]"
            )

    @property
    def closed(self) -> bool:
        """Whether it goes all the way round."""
        return self.last_deg - self.first_deg == 360

    def ends(self, look: FirstLook) -> tuple[int, int]:
        """The points that lie in the two directions."""
        first, last = (
            point_towards(look.body, ORIGIN, 0.0, np.radians(a)) for a in (self.first_deg, self.last_deg)
        )
        return first, last


@dataclass(frozen=True)
class BetweenPoints(Effective):
    """Between the contour points nearest to two places; the same place twice means all the way round."""

    first: Point
    """In the frame of the object's outline (m)."""
    last: Point

    @property
    def closed(self) -> bool:
        """Whether it goes all the way round."""
        return self.first == self.last

    def placed(self, start: Array, start_deg: float) -> "BetweenPoints":
        """The same, with places in the table frame."""
        turn = rotation(np.radians(start_deg))
        first, last = ((turn @ place + start).tolist() for place in (self.first, self.last))
        return BetweenPoints((first[0], first[1]), (last[0], last[1]))

    def ends(self, look: FirstLook) -> tuple[int, int]:
        """The points nearest to the places, which are in the table frame."""
        first, last = (
            lowest(np.linalg.norm(look.body - (np.array(place) - look.c) @ rotation(look.theta), axis=1))
            for place in (self.first, self.last)
        )
        return first, last


@dataclass(frozen=True)
class BetweenShares(Effective):
    """Between two shares of the contour's length, counted from where the principal direction meets it."""

    first: Share
    last: Share

    def __post_init__(self) -> None:
        if self.first == self.last:
            raise ValueError(f"last: {self.last:g} is first too; 0 and 1 mean all the way round")

    @property
    def closed(self) -> bool:
        """Whether it goes all the way round."""
        return abs(self.last - self.first) == 1

    def ends(self, look: FirstLook) -> tuple[int, int]:
        """The points at those shares."""
        m = len(look.body)
        return round(self.first * m) % m, round(self.last * m) % m
