"""`config.build`: what it builds, and what it says to each kind of mistake."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import pytest
from annotated_types import Ge, Gt, Interval
from omegaconf import OmegaConf

from deformpush.config import locate
from deformpush.config.build import build, check, component
from deformpush.config.schema import ConfigError


class Shape(Protocol):
    @property
    def size(self) -> float: ...

    def area(self) -> float: ...


@dataclass(frozen=True)
class Leaf:
    size: Annotated[float, Gt(0)]

    def area(self) -> float:
        return self.size**2

    def __post_init__(self) -> None:
        if self.size == 13:
            raise ValueError("size: 13 is unlucky; any other number above 0 will do")


@dataclass(frozen=True)
class Tree:
    leaf: Leaf
    count: Annotated[int, Interval(ge=1, le=5)]
    pair: tuple[float, float] = (0.0, 1.0)
    mode: Literal["all", "any"] = "all"
    maybe: Annotated[float, Ge(0)] | None = None
    flag: bool = False
    shapes: tuple[Shape, ...] = ()
    rng: Any = None


class Plain:
    """A user's class without hints or dataclass."""

    def __init__(self, a, *, b=2):
        self.a, self.b = a, b


class Open:
    def __init__(self, **anything):
        self.anything = anything


class FromUserModule:
    def __init__(self, n: "UnknownElsewhere"):  # noqa: F821 - a hint only type checkers can follow
        self.n = n


HERE = __name__
FOLDER = Path(__file__).resolve().parents[HERE.count(".")]
"""Where Python finds this module from."""
LEAF = {"_target_": f"{HERE}.Leaf", "size": 1.0}


@pytest.fixture(autouse=True)
def trusted(monkeypatch):
    """This folder is one that the user named with --config-dir; what is in it may be built."""
    monkeypatch.setattr(locate, "_trusted", [FOLDER])


def tree(**settings):
    node = {"_target_": f"{HERE}.Tree", "leaf": LEAF, "count": 2, **settings}
    return OmegaConf.create({"top": {"tree": node}}).top.tree


def test_builds_nested_components_and_hands_on_run_time_objects():
    rng = object()
    built = build(tree(pair=[1, 2], maybe=0.5), rng=rng)
    assert built == Tree(Leaf(1.0), 2, pair=(1.0, 2.0), maybe=0.5, rng=rng)
    assert isinstance(built.pair[0], float)
    assert built.rng is rng


def test_the_class_of_a_nested_dataclass_may_be_left_out():
    assert build(tree(leaf={"size": 3})).leaf == Leaf(3.0)


def test_components_inside_lists_are_built():
    assert build(tree(shapes=[LEAF, LEAF])).shapes == (Leaf(1.0), Leaf(1.0))


def test_builds_classes_that_are_no_dataclasses():
    plain = build(OmegaConf.create({"_target_": f"{HERE}.Plain", "a": [1]}))
    assert (plain.a, plain.b) == ([1], 2)
    assert build(OmegaConf.create({"_target_": f"{HERE}.Open", "x": 1})).anything == {"x": 1}
    assert build(OmegaConf.create({"_target_": f"{HERE}.FromUserModule", "n": 1})).n == 1


def test_interpolations_to_other_groups_are_followed():
    cfg = OmegaConf.create({"size": 4.0, "leaf": {"_target_": f"{HERE}.Leaf", "size": "${size}"}})
    assert build(cfg.leaf) == Leaf(4.0)


MISTAKES = [
    (
        {"cout": 1},
        "top.tree.cout: unknown (did you mean count?); top.tree has: leaf, count, pair, mode, maybe, flag, ",
    ),
    ({"count": 0}, "top.tree.count = 0: must be a whole number in [1, 5]"),
    ({"count": 2.0}, "top.tree.count = 2.0: must be a whole number in [1, 5]"),
    ({"count": True}, "top.tree.count = true: must be a whole number in [1, 5]"),
    ({"count": "2"}, 'top.tree.count = "2": must be a whole number in [1, 5]'),
    ({"count": None}, "top.tree.count = null: must be a whole number in [1, 5]"),
    ({"count": "???"}, "top.tree.count: missing; Tree needs it"),
    ({"pair": [1]}, "top.tree.pair = [1]: must be [a number, a number]"),
    ({"pair": [1, "x"]}, 'top.tree.pair = [1, "x"]: must be [a number, a number]'),
    ({"pair": 3}, "top.tree.pair = 3: must be [a number, a number]"),
    ({"mode": "some"}, 'top.tree.mode = "some": must be all or any'),
    ({"maybe": -1}, "top.tree.maybe = -1: must be a number of 0 or more or null"),
    ({"maybe": float("nan")}, "top.tree.maybe = nan: must be a number of 0 or more or null"),
    ({"flag": 1}, "top.tree.flag = 1: must be true or false"),
    ({"leaf": "Leaf"}, 'top.tree.leaf = "Leaf": must be Leaf'),
    ({"leaf": {"size": -1}}, "top.tree.leaf.size = -1: must be a number above 0"),
    ({"leaf": {"size": 13}}, "top.tree.leaf.size: 13 is unlucky; any other number above 0 will do"),
    ({"leaf": {}}, "top.tree.leaf.size: missing; Leaf needs it"),
    (
        {"leaf": {"_target_": f"{HERE}.Plain", "a": 1}},
        f"top.tree.leaf._target_ = {HERE}.Plain: must be a Leaf",
    ),
    (
        {"leaf": {"_target_": f"{HERE}.Lef"}},
        f"top.tree.leaf._target_ = {HERE}.Lef: {HERE} has no class Lef (did you mean Leaf?)",
    ),
    (
        {"leaf": {"_target_": "nowhere.Leaf"}},
        f"top.tree.leaf._target_ = nowhere.Leaf: is not a class of deformpush nor a file in {FOLDER}",
    ),
    (
        {"leaf": {"_target_": "deformpush.nowhere.Leaf"}},
        "top.tree.leaf._target_ = deformpush.nowhere.Leaf: cannot be imported: No module named 'deformpush.",
    ),
    ({"leaf": {"_target_": "Leaf"}}, "top.tree.leaf._target_ = Leaf: must be package.module.Class"),
    (
        {"leaf": {"_target_": "subprocess.Popen", "args": "true"}},
        "top.tree.leaf._target_ = subprocess.Popen: is not a class of deformpush nor a file in ",
    ),
    (
        {"shapes": [{"_target_": f"{HERE}.Plain", "a": 1}]},
        f"top.tree.shapes[0]._target_ = {HERE}.Plain: must be a Shape",
    ),
    (
        {"shapes": [LEAF, {"_target_": f"{HERE}.Leaf", "size": 0}]},
        "top.tree.shapes[1].size = 0: must be a number above 0",
    ),
    ({"pair": "${nowhere}"}, "top.tree.pair: Interpolation key 'nowhere' not found"),
]


@pytest.mark.parametrize(("settings", "message"), MISTAKES, ids=[str(s) for s, _ in MISTAKES])
def test_a_mistake_is_one_line_with_its_full_key(settings, message):
    with pytest.raises(ConfigError) as caught:
        build(tree(**settings), rng=None)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_a_component_is_what_it_is_asked_to_be():
    """Or has all that a protocol asks for; one of the user's own classes need not inherit from anything."""
    assert component(LEAF, "leaf", kind=Shape)() == Leaf(1.0)
    assert component(LEAF, "leaf", kind=Shape | None)() == Leaf(1.0)
    with pytest.raises(ConfigError, match=rf"^leaf\._target_ = {HERE}\.Leaf: must be a Plain or Open$"):
        component(LEAF, "leaf", kind=Plain | Open)


def test_where_the_users_own_class_does_not_say_what_it_takes_anything_may_be_built():
    assert build({"_target_": f"{HERE}.Plain", "a": LEAF}, "plain").a == Leaf(1.0)


def test_a_class_of_deformpush_takes_components_only_where_it_says_of_what_kind():
    with pytest.raises(
        ConfigError, match=rf"^fit\.rho_d\._target_ = {HERE}\.Leaf: no component belongs here$"
    ):
        build({"_target_": "deformpush.gp.fit.MAP", "rho_d": LEAF}, "fit")


def test_without_a_folder_of_the_users_only_classes_of_deformpush_are_built(monkeypatch):
    monkeypatch.setattr(locate, "_trusted", [])
    with pytest.raises(ConfigError, match=r"classes of your own come from a folder named with --config-dir$"):
        build(tree(), rng=None)


def test_a_run_time_argument_is_no_setting():
    with pytest.raises(ConfigError, match=r"top\.tree\.rng: unknown"):
        build(tree(rng=1), rng=None)


def test_a_node_without_target_or_no_mapping_at_all():
    with pytest.raises(ConfigError, match=r"leaf\._target_: missing"):
        build(OmegaConf.create({"leaf": {"size": 1}}).leaf)
    with pytest.raises(ConfigError, match=r'leaf = "ei": must be a group of settings'):
        build("ei", key="leaf")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 1.5}, "seed = 1.5: must be a whole number of 0 or more"),
        ({"max_pushes": 0}, "max_pushes = 0: must be a whole number of 1 or more"),
        ({"acq": "ei"}, 'acq = "ei": must stay a group of settings; .* acquisition=OPTION'),
        ({"oddity": 3}, "oddity = 3: must stay a group"),
    ],
)
def test_the_top_level_is_checked(change, message):
    good = {"seed": 0, "max_pushes": 8, "acq": {}, "options": {"acquisition": "lcb"}}
    check(good)
    with pytest.raises(ConfigError, match=message):
        check({**good, **change})
