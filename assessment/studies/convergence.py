"""The discretisation error of static results: increments are halved until the estimated error meets a tolerance.

The finest of 1, 1/2, 1/4… of the given increments is reported; the differences of the last ones give the error.
"""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from assessment.analyses.demand import Demands
from assessment.analyses.found import FIRST_ORDER, LEVELS, NOISE, SHOWN, accuracy_of, observed_order, refined
from assessment.analyses.states import StateResult
from assessment.project.model import StateModel
from assessment.project.project import Project
from assessment.results.schema import ConvergenceRow
from assessment.results.table import cells
from assessment.studies.variants import of_stages
from mechanics.messages import Message, headed, linked, message
from mechanics.model import Direction

Measured = Mapping[str, float | None]
SAFETY = 1.25  # on estimated errors, which are as often too small as too large (Roache's grid convergence index, 1994)
LOCATED = 1e-5  # relative: ends of paths that do not depend on increments agree to this
ERRORS = {
    "alpha_0": "alpha_0_error",
    "d_0_m": "d_0_error_m",
    "alpha_u": "alpha_u_error",
    "a_g_g": "a_g_error_g",
}


def estimated_error(values: Sequence[float | None]) -> float | None:
    """Estimate |v_n − v| of values v_0 … v_n at increments h, h/2, h/4…; None: the last two are not both known.

    Richardson's |v_n − v_n−1|/(r − 1), with r = |v_n−1 − v_n−2|/|v_n − v_n−1| from 1.25, below which no order shows, to
    2, of first order; of two values their difference; all with a factor of safety.
    """
    if len(values) < 2 or values[-1] is None or values[-2] is None:
        return None
    last = values[-1] - values[-2]
    if len(values) < 3 or values[-3] is None or last == 0.0:
        return SAFETY * abs(last)
    ratio = abs((values[-2] - values[-3]) / last)
    return SAFETY * abs(last) / (min(max(ratio, SHOWN), FIRST_ORDER) - 1.0)


@dataclass(frozen=True)
class Levels:
    """Quantities `measured` at each level: with the given increments, halved, halved again… (None: not reached).

    `size` (m): of the model; lengths below NOISE times it count as 0. The result is the finest level.
    """

    size: float
    measured: tuple[Measured, ...]

    def values(self, quantity: str) -> list[float | None]:
        """Return the values of a quantity, one for each level."""
        return [level.get(quantity) for level in self.measured]

    @property
    def reached(self) -> bool:
        """Whether any level gave any quantity."""
        return any(value is not None for level in self.measured for value in level.values())

    @property
    def errors(self) -> dict[str, float | None]:
        """Estimated error of each quantity that the last level or the one before reached; None: not known."""
        if len(self.measured) < 2:
            return {}
        counted = self.measured[-2:]
        return {
            key: estimated_error(self.values(key))
            for key in self.measured[-1]
            if any(level.get(key) is not None for level in counted)
        }

    @property
    def relative(self) -> dict[str, float | None]:
        """The errors, relative to the values of the result."""
        least = {key: NOISE * (self.size if key.endswith("_m") else 1.0) for key in self.errors}
        values = {key: max(abs(self.measured[-1][key] or 0.0), least[key]) for key in least}
        return {key: None if error is None else error / values[key] for key, error in self.errors.items()}

    def within(self, tolerance: float) -> bool:
        """Whether every error is known and meets the tolerance, of LEVELS levels at least.

        Two are enough where they agree as well as ends of paths are located: such a path knows no increments.
        """
        if not self.reached:
            return True
        bound = tolerance if len(self.measured) >= LEVELS else min(tolerance, LOCATED)
        known = self.relative.values()
        return len(self.measured) > 1 and all(error is not None and error <= bound for error in known)

    def row(self, state: str, direction: Direction, halvings: int, tolerance: float) -> ConvergenceRow:
        """Return the row of the results: errors, the largest relative one with its order, values of each level."""
        relative, worst = self.relative, None
        errors = {key: error for key, error in relative.items() if error is not None}
        if len(errors) == len(relative):
            worst = max(errors, key=lambda key: errors[key], default=None)
        return ConvergenceRow(
            state=state, direction=direction, halvings=halvings, met=self.within(tolerance),
            order=None if worst is None else observed_order(self.values(worst)),
            relative_error=None if worst is None else errors[worst],
            levels={key: self.values(key) for key in self.measured[-1]},
        ).replace(**{ERRORS[key]: error for key, error in self.errors.items()})  # fmt: skip


@dataclass
class Converged:
    """The finest stages of every state, and `halvings` of its increments behind them.

    `rows` of results.json; `warnings`: where the tolerance was not met.
    """

    stages: list[StateResult]
    halvings: dict[str, int] = field(default_factory=dict)
    rows: list[ConvergenceRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)


def converge(
    project: Project, models: Mapping[str, StateModel], demands: Demands,
    analyse: Callable[[Project, Collection[str]], list[StateResult]],
) -> Converged:  # fmt: skip
    """Analyse the states in ever finer increments until the errors of their capacities meet the tolerance.

    `analyse`: analyses the states of these names in the increments of a project. A state keeps its coarser analysis
    where the finer one fails. Without a tolerance (accuracy "fast") every state is analysed once.
    """
    accuracy = accuracy_of(project)
    found = Converged(analyse(project, project.states))
    if accuracy.tolerance is None:
        return found
    levels = {
        state: {way: Levels(models[state].assembly.size, (numbers,)) for way, numbers in measured.items()}
        for state, measured in measure(project, models, demands, found.stages).items()
    }
    found.halvings = dict.fromkeys(levels, 0)
    failed: dict[str, Message] = {}
    for halvings in range(1, accuracy.halvings + 1):
        wanted = [
            state
            for state, ways in levels.items()
            if state not in failed and not all(each.within(accuracy.tolerance) for each in ways.values())
        ]
        if not wanted:
            break
        finer = refined(project, halvings)
        stages = analyse(finer, wanted)
        measured = measure(finer, models, demands, stages)
        for state in wanted:
            before, after = (
                [text for stage in runs if stage.state == state for text in stage.failures]
                for runs in (found.stages, stages)
            )
            if len(after) > len(before):
                failed[state] = linked(after)
                continue
            found.halvings[state] = halvings
            levels[state] = {
                way: replace(each, measured=(*each.measured, measured[state][way]))
                for way, each in levels[state].items()
            }
        found.stages = [_finest(each, stages, failed) for each in found.stages]
    for state, ways in levels.items():
        for way, each in ways.items():
            if not each.reached:
                continue
            found.rows.append(each.row(state, way, found.halvings[state], accuracy.tolerance))
            title = message("{state}, {direction}", state=state, direction=way)
            if state in failed:
                reason = message("finer increments fail: {reason}", reason=failed[state])
                found.warnings.append(headed(title, reason))
            found.warnings += [headed(title, text) for text in not_met(each, accuracy.tolerance)]
    return found


def not_met(levels: Levels, tolerance: float) -> list[Message]:
    """Return a warning where the errors of `levels` do not meet the (relative) tolerance."""
    if levels.within(tolerance):
        return []
    times = 2 ** (len(levels.measured) - 1)
    if times == 1:
        return [message("discretisation error not known")]
    missed = [
        message("{key} is not known (not reached by every analysis)", key=key)
        if error is None
        else message("{key} is {error:.2g} %", key=key, error=100.0 * error)
        for key, error in levels.relative.items()
        if error is None or error > tolerance
    ]
    if not missed:
        return [message("two increments agree, which may be chance; a third was not reached")]
    return [
        message(
            "estimated discretisation error of {missed} with increments 1/{times} of those given, "
            "tolerance {tolerance:.2g} %; start from smaller increments",
            missed=linked(missed), times=times, tolerance=100.0 * tolerance,
        )
    ]  # fmt: skip


def measure(
    project: Project, models: Mapping[str, StateModel], demands: Demands, stages: Sequence[StateResult]
) -> dict[str, dict[Direction, Measured]]:
    """Return the quantities that have to converge (α, d_0 in m, a_g in g), by state and direction."""
    found: dict[str, dict[Direction, Measured]] = {}
    for state in dict.fromkeys(stage.state for stage in stages):
        own = [stage for stage in stages if stage.state == state]
        ways, _ = of_stages(project, models[state].assembly, own, demands)
        found[state] = {direction: cells(each, ERRORS) for direction, each in ways.items()}
    return found


def _finest(coarse: StateResult, stages: Sequence[StateResult], failed: Collection[str]) -> StateResult:
    """Return the finer result of the same state and contacts if there is one; the times of both are added."""
    same = (each for each in stages if (each.state, each.behaviour) == (coarse.state, coarse.behaviour))
    fine = next(same, None)
    if fine is None:
        return coarse
    kept, other = (coarse, fine) if coarse.state in failed else (fine, coarse)
    before = Counter(kept.coarser_seconds)
    before.update(other.seconds)
    kept.coarser_seconds = dict(before)
    return kept
