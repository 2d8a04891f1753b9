"""Postures along a straight path of the tool: planned at its points, interpolated between them."""

import numpy as np

from deformpush.cell.robot import KukaIiwa
from deformpush.cell.world import WorldError
from deformpush.mechanics.rounding import JOINTS, length, rounded
from deformpush.worlds.arm.inverse_kinematics import Kinematics, upright_posture

Array = np.ndarray


class PosturePath:
    """The postures of one push, by the place of the tool."""

    def __init__(self, points: Array, postures: Array) -> None:
        self._points, self._postures = points, postures
        self._chord = points[-1] - points[0]
        self._length = length(self._chord)
        self._along = np.linspace(0.0, self._length, len(postures))

    def at(self, xy: Array) -> tuple[Array, Array]:
        """Posture `(7,)` where the tool is at `xy` (m), and its slope dq/dxy along the path `(7, 2)`."""
        chord, whole, along, q = self._chord, self._length, self._along, self._postures
        done = xy - self._points[0]
        s = float(np.clip((done[0] * chord[0] + done[1] * chord[1]) / whole, 0.0, whole))
        i = min(int(np.searchsorted(along, s, side="right")) - 1, len(q) - 2)
        slope = (q[i + 1] - q[i]) / (along[i + 1] - along[i])
        return q[i] + slope * (s - along[i]), np.outer(slope, chord / whole)


class Planner:
    """Finds postures for one arm."""

    def __init__(self, arm: Kinematics, spec: KukaIiwa) -> None:
        self._arm, self._spec, self._rest = arm, spec, np.array(spec.rest)

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` have a posture within the joint limits."""
        return np.array([self._posture(p, self._rest) is not None for p in np.asarray(points)])

    def plan(self, points: Array) -> PosturePath:
        """Postures along tool positions `(P, 2)` on a line, at most a few millimetres apart.

        Raises:
            WorldError: a point is out of reach, or a joint would flip on the way.
        """
        postures, seed = [], self._rest
        for point in points:
            posture = self._posture(point, seed)
            if posture is None:
                raise WorldError(
                    f"the arm cannot reach ({point[0]:.3f}, {point[1]:.3f}) m with the tool upright"
                )
            seed = rounded(posture, JOINTS)
            postures.append(seed)
        q = np.array(postures)
        turn = np.abs(np.diff(q, axis=0)).max(initial=0.0)
        if turn > self._spec.max_turn:
            raise WorldError(
                f"the arm would flip: a joint turns {np.degrees(turn):.0f} degrees within one step"
            )
        return PosturePath(np.asarray(points), q)

    def _posture(self, xy: Array, seed: Array) -> Array | None:
        target = np.array([xy[0], xy[1], self._spec.tip_height])
        return upright_posture(self._arm, target, seed, self._rest)
