"""What every world must do, whoever wrote it: for `doctor`, and for the tests."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from deformpush.cell.cell import Cell
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import Capability, Outcome, Scenery, WorldError
from deformpush.checks.gate import Gate
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import Setup, read

Examine = Callable[[Cell, Setup], Gate]


def contract(overrides: Sequence[str]) -> Iterator[Gate]:
    """Put the world that these settings describe through its contract, one gate after the other.

    Each gate rests on those before it: the first that fails is the last.

    Raises:
        UserError: a setting is wrong, or the object cannot be seen.
    """
    setup = read(compose(overrides))
    cell = build_cell(setup)
    offered: dict[Capability, Examine] = {"branches": branches, "states": states}
    tried = [examine for name, examine in offered.items() if name in cell.world.offers]
    try:
        for examine in (picture, reach, mesh, push, *tried, beyond_reach):
            gate = examine(cell, setup)
            yield gate
            if not gate.passed:
                return
    except PerceptionError as problem:
        raise UserError(f"world={setup.options['world']}: {problem}") from problem
    finally:
        cell.world.close()


def picture(cell: Cell, setup: Setup) -> Gate:
    """The picture is RGB of the size that the camera states."""
    found, shape = cell.world.picture(), cell.camera.shape
    right = isinstance(found, np.ndarray) and found.dtype == np.uint8 and found.shape == shape
    told = f"{found.dtype} {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
    return Gate("picture", told, f"uint8 {shape}", right)


def reach(cell: Cell, setup: Setup) -> Gate:
    """`can_reach` answers for each point, and the tool can go where the object is."""
    seen = cell.look(None)[0].seen
    answer = np.asarray(cell.world.can_reach(np.vstack([seen.contour, seen.c])))
    right = answer.dtype == np.bool_ and answer.shape == (len(seen.contour) + 1,)
    share = f", {answer.mean():.0%} of the object" if right else ""
    right = right and bool(answer.any())
    return Gate("can_reach", f"{answer.dtype} {answer.shape}{share}", "a bool a point, some true", right)


def mesh(cell: Cell, setup: Setup) -> Gate:
    """Nodes, triangles and strain belong to one mesh, or there is none."""
    world, scenery = cell.world, cell.world.scenery()
    if not isinstance(scenery, Scenery):
        return Gate("nodes, strain, scenery", f"scenery: {type(scenery).__name__}", "a Scenery", False)
    nodes, strain, triangles, right = world.nodes(), world.strain(), scenery.mesh_triangles, True
    if nodes is not None:
        right &= nodes.ndim == 2 and nodes.shape[1] == 3 and bool(np.isfinite(nodes).all())
    if triangles is not None:
        right &= nodes is not None and int(triangles.max()) < len(nodes)
    if strain is not None:
        right &= nodes is not None and strain.shape == (len(nodes),)
    right &= (strain is not None) == ("strain" in world.offers)
    told = "no mesh" if nodes is None else f"{len(nodes)} nodes"
    return Gate("nodes, strain, scenery", told, "of one mesh", bool(right))


def branches(cell: Cell, setup: Setup) -> Gate:
    """Pushes tried in copies of the world leave the world itself as it was."""
    before, seen = cell.world.picture(), cell.look(None)[0].seen
    pushes = np.array([[0.3, setup.object.d[0]], [0.7, setup.object.d[1]]])
    looks = cell.seen_after(pushes, seen)
    same = bool(np.array_equal(before, cell.world.picture()))
    made = sum(look is not None for look in looks)
    return Gate(
        "branches", f"{made} of {len(pushes)} pushes tried", "the world stays as it was", same and made > 0
    )


def push(cell: Cell, setup: Setup) -> Gate:
    """A push moves the object the way the tool goes, and tells what the world says it offers."""
    before = cell.look(None)[0].seen
    try:
        _, path = cell.reachable(np.array([0.5, setup.object.d[1]]), before)
        outcome = cell.world.push(path)
    except WorldError as problem:
        return Gate("push", str(problem), "made", False)
    if not isinstance(outcome, Outcome):
        return Gate("push", f"returns {type(outcome).__name__}", "an Outcome", False)
    offers = cell.world.offers
    tells = {
        "strain": outcome.strain is not None,
        "film": bool(outcome.film),
        "force": outcome.tool_force_peak is not None and outcome.tool_force_mean is not None,
    }
    for name, told in tells.items():
        if told != (name in offers):
            return Gate("push", f"{'tells' if told else 'lacks'} {name}", "told as far as offered", False)
    forward = float((cell.look(before)[0].seen.c - before.c) @ path.direction)
    moved = f"{forward * 1e3:.1f} mm forward for {path.d * 1e3:.0f} mm"
    return Gate("push", moved, "0.1 to 1.5 times d", 0.1 * path.d < forward < 1.5 * path.d)


def states(cell: Cell, setup: Setup) -> Gate:
    """A saved state is returned to: it looks the same and answers a push the same; others are refused."""
    world, seen = cell.world, cell.look(None)[0].seen
    try:
        _, path = cell.reachable(np.array([0.25, setup.object.d[1]]), seen)
        state = world.save()
        looks = []
        for _ in range(2):
            world.restore(state)
            before = world.picture()
            world.push(path)
            looks.append(np.stack([before, world.picture()]))
        world.restore(state)
    except WorldError as problem:
        return Gate("states", str(problem), "returned to", False)
    if not np.array_equal(looks[0], looks[1]) or not np.array_equal(looks[0][0], world.picture()):
        return Gate("states", "returned to something else", "the same, to the bit", False)
    try:
        world.restore(b"no state of this world")
    except ValueError:
        return Gate("states", f"{len(state) / 1e3:.0f} kB, returned to", "the same, to the bit", True)
    return Gate("states", "takes up what is no state", "a ValueError", False)


def beyond_reach(cell: Cell, setup: Setup) -> Gate:
    """A push out of reach is refused and moves nothing; a world that reaches everywhere has none."""
    seen = cell.look(None)[0].seen
    path = cell.layout.plan(np.array([0.5, 0.01]), seen, cell.part)
    far = type(path)(path.start + 100.0, path.direction, path.approach, path.d)
    if cell.world.can_reach(np.stack([far.start, far.end])).all():
        return Gate("push out of reach", "reaches everywhere", "WorldError, nothing moves", True)
    try:
        cell.world.push(far)
        said = "made"
    except WorldError:
        said = "refused"
    moved = float(np.linalg.norm(cell.look(seen)[0].seen.c - seen.c))
    return Gate("push out of reach", said, "WorldError, nothing moves", said == "refused" and moved < 1e-3)
