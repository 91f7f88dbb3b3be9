"""A case of the stress tests, its verdict, and what every result has to be."""

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, is_dataclass

import numpy as np

from mechanics import Assembly
from mechanics.errors import ArgumentError, ControlError, ConvergenceError, NoEquilibriumError, UnstableError
from mechanics.model.contacts import Contacts
from mechanics.program import Certificate
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_system import StaticSystem

USABLE = 1e-6  # the certificate that the program itself asks for (mechanics.solvers)
REFUSALS = (UnstableError, NoEquilibriumError, ControlError, ConvergenceError)


@dataclass(frozen=True)
class Case:
    """`run` analyses and checks the numbers; a refusal of a class in `may_refuse` is an answer too.

    `bad_input` is text of the ValueError that a bad argument must meet, naming it. A case that `must_refuse` has no
    answer.
    """

    group: str
    name: str
    run: Callable[[], None]
    may_refuse: tuple[type[Exception], ...] = ()
    must_refuse: bool = False
    bad_input: str = ""
    long: bool = False

    @property
    def label(self) -> str:
        return f"{self.group}: {self.name}"

    def judge(self) -> str:
        """Run it: "certified", or "refused" in words; whatever else happens is raised."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                self.run()
        except self.may_refuse as refusal:
            assert isinstance(refusal, REFUSALS) and str(refusal), "a refusal without a reason"
            return "refused"
        except ValueError as refusal:
            if not self.bad_input:
                raise
            assert type(refusal) in (ValueError, ArgumentError) and self.bad_input in str(refusal)
            return "refused"
        assert not (self.must_refuse or self.bad_input), "answered, where there is no answer"
        return "certified"


def sound(result: object, step: float = 0.0) -> None:
    """Assert that every number within a result is finite and every certificate good.

    `step` (m): the displacement to which penetration is relative; 0: its own test leaves penetration out.
    """
    for value in _within(result):
        if isinstance(value, Certificate):
            worst = value.worst(step) if step else max(value.equilibrium, value.cone, value.work)
            assert worst <= USABLE, f"certificate {worst:.2g}: {value}"
        elif isinstance(value, np.ndarray | float) and np.asarray(value).dtype.kind == "f":
            assert np.isfinite(value).all(), "a number that is not finite"


def _within(result: object) -> Iterator[object]:
    yield result
    inner: Iterable[object] = ()
    if isinstance(result, tuple | list):
        inner = result
    elif is_dataclass(result) and not isinstance(
        result, (Assembly, Certificate, Contacts, StaticSystem, Iterate)
    ):
        inner = (getattr(result, field.name) for field in fields(result))
    for value in inner:
        yield from _within(value)
