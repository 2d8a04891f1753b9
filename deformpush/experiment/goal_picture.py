"""Makes a goal that is given as a picture into an outline, before a run begins."""

from copy import deepcopy
from dataclasses import replace

from deformpush.cell import picture_file
from deformpush.cell.perception import PerceptionError
from deformpush.errors import UserError
from deformpush.experiment.assemble import camera_of
from deformpush.experiment.setup import Setup
from deformpush.mechanics.rounding import METRES, rounded

KEY = "task.goal.picture"


def looked_at(setup: Setup) -> Setup:
    """The same run with the outline of what its goal picture shows; config.yaml then needs the file no more.

    Raises:
        UserError: the file is no picture, not one of the run's camera, or shows no object.
    """
    goal = setup.task.goal
    if goal.picture is None or goal.outline is not None:
        return setup
    camera = camera_of(setup)
    try:
        picture = picture_file.read(goal.picture)
        if picture.shape != camera.shape:
            is_px, must_px = (f"{shape[1]} x {shape[0]}" for shape in (picture.shape, camera.shape))
            raise ValueError(f"has {is_px} pixels, the run's camera takes {must_px}")
        seen = setup.contour.observe(camera.rectified(picture), camera)
    except (ValueError, PerceptionError) as problem:
        raise UserError(f"{KEY} = {goal.picture}: {problem}") from problem
    outline = rounded(seen.contour, METRES).tolist()
    values = deepcopy(dict(setup.values))
    values["task"]["goal"]["outline"] = outline
    goal = replace(goal, outline=tuple((x, y) for x, y in outline))
    return replace(setup, task=replace(setup.task, goal=goal), values=values)
