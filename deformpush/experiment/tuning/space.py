"""What is varied and what is fixed: settings in Hydra's own grammar, read for Optuna."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from deformpush.errors import UserError

if TYPE_CHECKING:
    from hydra.core.override_parser.types import Override

OPTIMIZER = (
    *("acq", "acquisition", "optimizer", "model", "kernel", "mean", "fit"),
    *("bounds", "design", "minimiser"),
)
"""Groups that make up the optimizer; all others are the task, which a tuning must not change."""
NOT_HERE = {"seed": "--seeds says which", "hydra": "--out names the folder", "sweep": "it is no sweep"}


@dataclass(frozen=True)
class Space:
    """The settings of a tuning."""

    ranges: dict[str, Any]
    """Optuna's distribution by key, in the order given."""
    fixed: tuple[str, ...]
    """Settings that are the same in all trials."""

    def overrides(self, values: Mapping[str, Any]) -> list[str]:
        """The settings of a trial, for these values of the ranges."""
        return [*self.fixed, *told(values)]


def told(values: Mapping[str, Any]) -> list[str]:
    """Values of the ranges as one types them, every digit kept."""
    return [f"{key}={value if isinstance(value, str) else repr(value)}" for key, value in values.items()]


def parse(settings: Sequence[str]) -> Space:
    """Tell ranges from plain settings.

    A range is `KEY=interval(LOW, HIGH)`, `KEY=int(interval(LOW, HIGH))`, `KEY=range(FIRST, END, STEP)` or
    `KEY=A,B,C`; the first three may stand in `tag(log, ...)`, to be searched by orders of magnitude.

    Raises:
        UserError: a setting cannot be read, is no one's to vary, or nothing is varied.
    """
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import OverrideParseException

    from deformpush.config.compose import explain

    ranges: dict[str, Any] = {}
    fixed: list[str] = []
    for text in settings:
        try:
            (override,) = OverridesParser.create().parse_overrides([text])
        except OverrideParseException as error:
            raise UserError(explain(error, settings)) from error
        key = text.partition("=")[0].strip()
        group = key.lstrip("+~").partition(".")[0].partition("/")[0].partition("@")[0]
        if group in NOT_HERE:
            raise UserError(f"{text}: not in a tuning; {NOT_HERE[group]}")
        if not override.is_sweep_override():
            fixed.append(text)
        elif group not in OPTIMIZER:
            raise UserError(f"{text}: a range must be of the optimizer: {', '.join(OPTIMIZER)}")
        else:
            ranges[key] = _distribution(text, override)
    if not ranges:
        raise UserError(
            "no range to tune; an example is 'acq.w=tag(log, interval(0.5, 4))' kernel=matern52,rbf"
        )
    if not any(text.partition("=")[0] == "record" for text in fixed):
        fixed.insert(0, "record=off")
    return Space(ranges, tuple(fixed))


def _distribution(text: str, override: "Override") -> Any:
    """Optuna's distribution for a range.

    Raises:
        UserError: there is none.
    """
    from hydra.core.override_parser.types import ChoiceSweep, IntervalSweep, RangeSweep
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    value = override.value()
    log = "log" in getattr(value, "tags", ())
    try:
        if isinstance(value, IntervalSweep):
            low, high = value.start, value.end
            whole = isinstance(low, int) and isinstance(high, int)
            kind = IntDistribution if whole else FloatDistribution
            return kind(low, high, log=log)
        if isinstance(value, RangeSweep):
            each = list(value.range())
            whole = all(isinstance(one, int) for one in each)
            kind = IntDistribution if whole else FloatDistribution
            return kind(min(each), max(each), log=log, step=abs(value.step))
        if isinstance(value, ChoiceSweep):
            return CategoricalDistribution(list(override.sweep_string_iterator()))
    except (ValueError, TypeError) as error:
        raise UserError(f"{text}: no range: {' '.join(str(error).split())}") from error
    raise UserError(f"{text}: not a range that can be tuned; use interval(), range() or A,B,C")
