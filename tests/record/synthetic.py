"""A made-up run: a soft rectangle walks to its goal by a rule of thumb, without a simulator."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.observation import Observation, View
from deformpush.cell.push import Line, ToolPath
from deformpush.cell.world import Moment, Outcome, Scenery, Strain
from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.mesh import TetMesh, slab
from deformpush.mechanics.strain import RestShape
from deformpush.push_record import EFFECTIVE_POINTS, Action, PushRecord, RunInfo, Timing
from deformpush.record.forecasts import actual
from deformpush.state import Forecast, Proposal
from deformpush.task import ERROR_COLUMNS, Errors, Stop, Target

LENGTH, WIDTH, THICKNESS, TOOL = 0.2, 0.1, 0.02, 0.01
CAMERA = Camera(centre=(0.55, 0.0), field=0.6, distance=1.0, pixels=480, plane_z=THICKNESS / 2)
START, GOAL = np.array([0.5, -0.12, np.radians(25)]), np.array([0.62, 0.06, 0.0])
OUTER = np.array([[0.0, 1.0], [0.01, 0.03]])
GRID = 32
LIMIT = 0.1
FORCE_LIMIT = 2.5
LENGTH_TO_GOAL = float(np.linalg.norm((START - GOAL)[:2]))
FORECAST_STD = np.array([1e-3, 2e-3, 0.02, 0.01])
CONFIG = "object:\n  name: rect\nacq:\n  w: 1.0\nseed: 0\nrecord:\n  spawn: false\n"


def outline(n: int = 200) -> np.ndarray:
    """Evenly spaced rectangle outline about the origin, counter-clockwise."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * (LENGTH / 2, WIDTH / 2)
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))]
    at = np.linspace(0, along[-1], n, endpoint=False)
    return np.stack([np.interp(at, along, corners[:, i]) for i in (0, 1)], 1)


class SyntheticRun:
    """Pose (x, y, theta) and a bend (1/m) that grows with every push; pushes shift and turn the slab."""

    def __init__(
        self,
        pushes: int = 60,
        seed: int = 0,
        mesh: bool = True,
        urdf: str | None = None,
        forecasts: bool = False,
        force: bool = False,
    ) -> None:
        self.pushes, self.rng, self.body = pushes, np.random.default_rng(seed), outline()
        self.slab: TetMesh | None = slab(self.body, THICKNESS, 0.02) if mesh else None
        self.rest = RestShape(self.slab) if self.slab else None
        self.pose, self.bend, self.data = START.copy(), 0.0, np.zeros((0, 3))
        self.arm = Arm(urdf) if urdf else None
        model = "motion" if forecasts else "error"
        self.info = RunInfo(
            title="rect, LCB, seed 0 (synthetic)", config_yaml=CONFIG,
            options={"object": "rect", "model": model, "acquisition": "lcb", "optimizer": "abo"},
            seed=seed, initial_samples=10, max_pushes=80, camera=CAMERA,
            target=Target(GOAL[:2], float(GOAL[2]), np.ones((2, 2), bool), self.body, LENGTH_TO_GOAL),
            stop=Stop(0.02, 7.0, 0.15), outer_bounds=OUTER, tool_radius=TOOL, strain_limit=LIMIT,
            scenery=Scenery(
                table_centre=(0.55, 0.0, -0.025), table_half_size=(0.35, 0.4, 0.025), arm_urdf=urdf,
                mesh_triangles=None if self.slab is None else self.slab.surface(),
            ),
        )  # fmt: skip
        self.forecasts, self.force = forecasts, force
        if force:
            self.info = replace(self.info, force_limit=FORCE_LIMIT, offers=frozenset({"force"}))

    def records(self) -> list[PushRecord]:
        """Row 0 and one record per push."""
        rows = [self._row(0, None)]
        for k in range(1, self.pushes + 1):
            rows.append(self._push(k, rows[-1]))
        return [rows[0], *map(foretold, rows[1:])] if self.forecasts else rows

    def placed(self, pose: np.ndarray, bend: float, body: np.ndarray) -> np.ndarray:
        """Body points `(N, 2)` at a pose, bent along x."""
        bent = body + np.stack([np.zeros(len(body)), bend * (body[:, 0] ** 2 - LENGTH**2 / 12)], 1)
        return bent @ rotation(pose[2]).T + pose[:2]

    def moved(self, kappa: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Pose after a push, by a rule of thumb, for arrays of pushes: `(..., 3)`."""
        index = (np.asarray(kappa) * (len(self.body) - 1)).astype(int)
        point, inward = self.body[index], -self._normals()[index]
        lever = point[..., 0] * inward[..., 1] - point[..., 1] * inward[..., 0]
        shift = (inward @ rotation(self.pose[2]).T) * (d * (1 - 4 * np.abs(lever)))[..., None]
        return self.pose + np.concatenate([shift, (d * lever * 150)[..., None]], -1)

    def total(self, pose: np.ndarray) -> np.ndarray:
        turn = np.abs(pose[..., 2] - GOAL[2]) / np.pi
        away = np.linalg.norm(pose[..., :2] - GOAL[:2], axis=-1)
        return 3 * away / LENGTH_TO_GOAL + turn + self._gamma()

    def _push(self, k: int, before: PushRecord) -> PushRecord:
        grid = np.stack(np.meshgrid(*(np.linspace(*row, GRID) for row in OUTER)), -1)
        mean = self.total(self.moved(grid[..., 0], grid[..., 1])) - self.total(self.pose)
        proposal, maps = self._propose(k, grid, mean)
        kappa, d = proposal.u
        contour = self.placed(self.pose, self.bend, self.body)
        index = int(kappa * (len(self.body) - 1))
        inward = -self._normals()[index] @ rotation(self.pose[2]).T
        path = ToolPath(contour[index] - TOOL * inward, inward, 0.0, float(d))
        start_pose, start_bend = self.pose, self.bend
        final = self.moved(np.array(kappa), np.array(d))
        final += self.rng.normal(0, [2e-3, 2e-3, 0.02])
        self.bend += 0.02 * self.rng.normal()
        motion = []
        for i, share in enumerate(np.linspace(0.2, 1.0, 5)):
            pose = start_pose + share * (final - start_pose)
            bend = start_bend + share * (self.bend - start_bend)
            tool = np.r_[path.start + share * (path.end - path.start), THICKNESS / 2]
            nodes = self._nodes(pose, bend)
            motion.append(Moment(0.2 * (i + 1), tool, nodes, self._joints(tool), self._strain(nodes)))
        self.pose = final
        outcome = Outcome(steps=480, step_s=0.9, sim_s=2.0, motion=motion, strain=self._strained(float(d)))
        if self.force:
            outcome.tool_force_peak, outcome.tool_force_mean = 100 * float(d), 60 * float(d)
            outcome.force_limit = FORCE_LIMIT
        xi = self._errors().e_T - before.errors.e_T
        self.data = np.vstack([self.data, [kappa, d, xi]])
        line = Line.of(np.arange(len(contour)), contour, len(contour) + 1)
        return self._row(
            k, Action(proposal, proposal.u, path, outcome, xi, line.places(EFFECTIVE_POINTS), maps)
        )

    def _propose(self, k: int, grid: np.ndarray, mean: np.ndarray) -> tuple[Proposal, dict[str, np.ndarray]]:
        bounds = OUTER.copy()
        if k <= self.info.initial_samples:
            return Proposal(self.rng.uniform(*OUTER.T), "initial", bounds), {}
        scaled = (grid[..., None, :] - self.data[:, :2]) / (OUTER[:, 1] - OUTER[:, 0])
        std = 0.3 * (1 - np.exp(-np.min(np.linalg.norm(scaled, axis=-1), -1) / 0.15)) + 0.02
        acq = mean + self.rng.normal(0, 0.005, mean.shape) - std
        phase = "explore" if self.rng.random() < 0.2 else "exploit"
        best = np.unravel_index(np.argmin(acq if phase == "explore" else mean), acq.shape)
        width = 0.25 + 0.2 * np.cos(k / 6)
        bounds[0] = np.clip([grid[best][0] - width, grid[best][0] + width], 0, 1)
        told = tuple(float(values[best]) for values in (acq, mean, std))
        info = {"length_kappa": 0.2, "length_d": 0.01, "length_t": 15.0, "noise": 1e-3}
        return Proposal(grid[best], phase, bounds, *told, info), {"mean": mean, "std": std, "acq": acq}

    def _row(self, k: int, action: Action | None) -> PushRecord:
        contour = self.placed(self.pose, self.bend, self.body)
        c, theta = contour.mean(0), float(self.pose[2])
        tool = np.r_[c - (0.15, 0), 0.15] if action is None else np.r_[action.path.start, 0.1]
        nodes = self._nodes(self.pose, self.bend)
        seen = Observation(contour, c, theta, np.ones((2, 2), bool), compact=False)
        view = View(draw(contour), seen, nodes, self._joints(tool), self._strain(nodes))
        return PushRecord(k, view, self._errors(), Timing(0.02, 0.03, 2.0 * k), action)

    def _errors(self) -> Errors:
        """Errors of the pose as it is; of terms that the paper does not have, 0.25."""
        away = float(np.linalg.norm(self.placed(self.pose, self.bend, self.body).mean(0) - GOAL[:2]))
        turn, e_c = abs(float(self.pose[2])), away / LENGTH_TO_GOAL
        known = {"e_c": e_c, "e_theta": turn / np.pi, "e_gamma": self._gamma()}
        known |= {"e_T": 3 * e_c + turn / np.pi + self._gamma()}
        known |= {"position_error_m": away, "angle_error_rad": turn}
        return Errors({column: known.get(column, 0.25) for column in ERROR_COLUMNS})

    def _strained(self, d: float) -> Strain | None:
        """The longer the push, the more: a rule of thumb."""
        if self.rest is None:
            return None
        p99, rest = 4 * d, self._strain(self._nodes(self.pose, self.bend))
        return Strain(p99, 0.6 * p99, 1.2 * p99, float(rest.max()), LIMIT, rest + p99)

    def _gamma(self) -> float:
        return 0.05 + 0.2 * abs(self.bend)

    def _nodes(self, pose: np.ndarray, bend: float) -> np.ndarray | None:
        if self.slab is None:
            return None
        return np.column_stack([self.placed(pose, bend, self.slab.nodes[:, :2]), self.slab.nodes[:, 2]])

    def _strain(self, nodes: np.ndarray | None) -> np.ndarray | None:
        return None if self.rest is None else self.rest.at_nodes(self.rest.strain(nodes))

    def _joints(self, tool: np.ndarray) -> dict[str, float]:
        return self.arm.reach(tool) if self.arm else {}

    def _normals(self) -> np.ndarray:
        """Outward unit normals of the body's outline `(M, 2)`, rounded at the corners."""
        tangent = np.roll(self.body, -3, 0) - np.roll(self.body, 3, 0)
        return np.stack([tangent[:, 1], -tangent[:, 0]], 1) / np.linalg.norm(tangent, axis=1, keepdims=True)


def foretold(
    row: PushRecord, off: np.ndarray | float | None = None, std: np.ndarray = FORECAST_STD
) -> PushRecord:
    """A record with a forecast that is `off` by a vector; by 0, 1 or 2 `std` unless told otherwise."""
    forecast = Forecast(actual(row) + (std * (row.k % 3) if off is None else off), np.diag(np.square(std)))
    action = replace(row.action, proposal=replace(row.action.proposal, forecast=forecast))
    return replace(row, action=action)


class Arm:
    """Joint angles of the Kuka for a tool position, tool pointing down."""

    def __init__(self, urdf: str) -> None:
        import pybullet

        self.bullet, self.client = pybullet, pybullet.connect(pybullet.DIRECT)
        self.body = pybullet.loadURDF(urdf, useFixedBase=True, physicsClientId=self.client)
        count = pybullet.getNumJoints(self.body, physicsClientId=self.client)
        infos = [pybullet.getJointInfo(self.body, i, physicsClientId=self.client) for i in range(count)]
        self.names = [row[1].decode() for row in infos]

    def reach(self, tool: np.ndarray) -> dict[str, float]:
        down = self.bullet.getQuaternionFromEuler([np.pi, 0, 0])
        flange, last = tool + np.array([0, 0, 0.1]), len(self.names) - 1
        angles = self.bullet.calculateInverseKinematics(
            self.body, last, flange, down, maxNumIterations=100, physicsClientId=self.client
        )
        for i, angle in enumerate(angles):
            self.bullet.resetJointState(self.body, i, angle, physicsClientId=self.client)
        return dict(zip(self.names, angles, strict=True))


def draw(contour: np.ndarray) -> np.ndarray:
    """What the camera would see: a blue object on white."""
    image = np.full((CAMERA.pixels, CAMERA.pixels, 3), 250, np.uint8)
    points = np.round(CAMERA.to_px(contour) * 16).astype(np.int32)
    cv2.fillPoly(image, [points], (60, 90, 200), cv2.LINE_AA, shift=4)
    return image


def kuka() -> str:
    """The arm's URDF as it ships with PyBullet."""
    import pybullet_data

    return str(Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf")
