"""A study of Optuna in an SQLite file, asked and told one trial at a time, so that it can stop anywhere."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deformpush import __version__
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.tuning.space import Space
from deformpush.extras import library

DATABASE = "study.db"
ATTRIBUTE = "tuning"


@dataclass(frozen=True)
class Trial:
    """One choice of the settings and what came of it."""

    number: int
    values: dict[str, Any]
    costs: list[float]
    """One per seed; empty where the settings did not fit."""
    reason: str
    """Why they did not."""

    @property
    def mean(self) -> float:
        """The objective."""
        return sum(self.costs) / len(self.costs) if self.costs else float("inf")


class Trials:
    """The trials of a folder; a trial that a killed process had begun is taken up first."""

    def __init__(self, folder: Path, space: Space, seeds: Sequence[int]) -> None:
        """Open the study of `folder`, or begin it.

        Raises:
            UserError: optuna is missing, or the folder holds a tuning of other settings.
            TroubleError: the file cannot be read or written.
        """
        optuna = library("optuna", "tune", "tune")
        self._optuna, self._space, self._file = optuna, space, folder / DATABASE
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        now = {
            "ranges": {key: optuna.distributions.distribution_to_json(d) for key, d in space.ranges.items()},
            "fixed": list(space.fixed),
            "seeds": list(seeds),
            "version": __version__,
        }
        with self._told():
            self._study = optuna.create_study(
                storage=f"sqlite:///{self._file.resolve()}", study_name="tune", load_if_exists=True
            )
            then = json.loads(self._study.user_attrs.get(ATTRIBUTE, "null"))
            if then is None:
                self._study.set_user_attr(ATTRIBUTE, json.dumps(now))
        if then is not None and (other := [key for key in now if now[key] != then.get(key)]):
            raise UserError(
                f"{folder}: holds a tuning with other {other[0]} "
                f"({then.get(other[0])}, not {now[other[0]]}); name another --out"
            )

    def make(self, total: int, run: Callable[[int, list[str]], list[float]]) -> Iterator[Trial]:
        """Make trials until there are `total`; yield each as it is done.

        Args:
            total: trials in all, those of earlier commands included.
            run: makes the runs of a trial from its number and settings; returns their costs.

        Raises:
            TroubleError: the study cannot be written.
        """
        optuna, State = self._optuna, self._optuna.trial.TrialState
        with self._told():
            begun = [trial.number for trial in self._study.get_trials(states=[State.RUNNING])]
            number = len(self._study.trials)
        while begun or number < total:
            with self._told():
                if begun:
                    trial = self._study.trials[begun.pop(0)]
                else:
                    # A sampler of its own for every trial: what it draws depends on the trials before alone,
                    # not on whether the process was stopped between them.
                    self._study.sampler = optuna.samplers.TPESampler(seed=number)
                    trial = self._study.ask(self._space.ranges)
                    number += 1
            values = {key: trial.params[key] for key in self._space.ranges}
            try:
                costs, reason = run(trial.number, self._space.overrides(values)), ""
            except TroubleError:
                raise
            except UserError as error:
                costs, reason = [], str(error)
            made = Trial(trial.number, values, costs, reason)
            with self._told():
                self._tell(made)
            yield made

    def done(self) -> list[Trial]:
        """All trials that came to an end, by number."""
        with self._told():
            found = [trial for trial in self._study.trials if trial.state.is_finished()]
        return [
            Trial(
                t.number,
                {key: t.params[key] for key in self._space.ranges},
                t.user_attrs.get("costs", []),
                t.user_attrs.get("reason", ""),
            )
            for t in found
        ]

    def _tell(self, made: Trial) -> None:
        storage, state = self._study._storage, self._optuna.trial.TrialState
        identity = storage.get_trial_id_from_study_id_trial_number(self._study._study_id, made.number)
        storage.set_trial_user_attr(identity, "costs", made.costs)
        storage.set_trial_user_attr(identity, "reason", made.reason)
        if made.costs:
            self._study.tell(made.number, made.mean)
        else:
            self._study.tell(made.number, state=state.FAIL)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Make one line of what the database complains of."""
        try:
            yield
        except Exception as error:
            if type(error).__module__.partition(".")[0] not in ("sqlalchemy", "sqlite3", "optuna", "alembic"):
                raise
            cause = error.__cause__ or error
            first = str(getattr(cause, "orig", cause)).splitlines()[0]
            raise TroubleError(f"{self._file}: cannot be used as a study: {first}") from error
