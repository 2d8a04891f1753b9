"""A description of the arm that a recorder can draw: capsules between the joints, and the tool."""

import math

from deformpush.worlds.arm.iiwa import FLANGE, JOINTS, Joint

_ARM, _WRIST = 0.068, 0.05  # m; radius of the capsules, about half the width of the real housings
_COLOURS = {"housing": "0.93 0.93 0.93 1", "ring": "0.95 0.45 0.1 1", "tool": "0.35 0.35 0.38 1"}


def urdf(tool_length: float, tool_radius: float) -> str:
    """The arm on its base, with a cylinder on its flange (both m)."""
    colours = [f'<material name="{name}"><color rgba="{c}"/></material>' for name, c in _COLOURS.items()]
    parts = [*colours, _link("base", _cylinder(0.1, 0.04, "housing"))]
    parent = "base"
    for joint, after in zip(JOINTS, [*JOINTS[1:], None], strict=True):
        housing = _capsule(_ARM, after.offset) if after else _cylinder(_WRIST, FLANGE, "housing")
        link = joint.name.replace("joint", "link")
        parts += [_moving_joint(joint, parent, link), _link(link, housing)]
        parent = link
    parts += [_fixed_joint("tool_joint", parent, "tool", FLANGE)]
    parts += [_link("tool", _cylinder(tool_radius, tool_length, "tool"))]
    parts += [_fixed_joint("tool_tip_joint", "tool", "tool_tip", tool_length), _link("tool_tip", "")]
    return '<?xml version="1.0"?>\n<robot name="kuka_iiwa">\n  ' + "\n  ".join(parts) + "\n</robot>\n"


def _link(name: str, look: str) -> str:
    return f'<link name="{name}">{look}</link>'


def _moving_joint(joint: Joint, parent: str, child: str) -> str:
    x, y, z = joint.axis
    limit = math.radians(joint.limit_deg)
    return (
        f'<joint name="{joint.name}" type="revolute">{_between(parent, child, joint.offset)}'
        f'<axis xyz="{x} {y} {z}"/>'
        f'<limit lower="{-limit:.9f}" upper="{limit:.9f}" effort="300" velocity="1.5"/></joint>'
    )


def _fixed_joint(name: str, parent: str, child: str, offset: float) -> str:
    return f'<joint name="{name}" type="fixed">{_between(parent, child, offset)}</joint>'


def _between(parent: str, child: str, offset: float) -> str:
    return f'<origin xyz="0 0 {offset:g}"/><parent link="{parent}"/><child link="{child}"/>'


def _capsule(radius: float, length: float) -> str:
    """The straight part from a joint to the next one; where both are in one place, the ball between two."""
    if not length:
        return _visual(f'<sphere radius="{1.08 * radius:g}"/>', 0.0, "ring")
    return _cylinder(radius, length, "housing")


def _cylinder(radius: float, length: float, colour: str) -> str:
    return _visual(f'<cylinder radius="{radius:g}" length="{length:g}"/>', length / 2, colour)


def _visual(shape: str, height: float, colour: str) -> str:
    where = f'<origin xyz="0 0 {height:g}"/>'
    return f'<visual>{where}<geometry>{shape}</geometry><material name="{colour}"/></visual>'
