"""How far elastic results are from converged in the segments of the joints: those given doubled, and doubled again.

Every state is settled and pushed over with elastic joints once more, at the increments given. The results stay those of
the segments given, since whatever starts from a settled state needs its contact points; only their error is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from assessment.convergence import Levels, accuracy_of, measure
from assessment.states import Request, analyse_states
from assessment.study import behaviours

if TYPE_CHECKING:
    from assessment.parallel import Workers
    from assessment.project import Project
    from assessment.states import StateResult
    from assessment.study import Demands
    from mechanics import Assembly

Numbers = dict[str, Any]
TIMES = (2, 4)  # what the segments given are multiplied by
QUANTITIES = ("alpha_u", "a_g_g")


@dataclass
class Estimates:
    """`rows` of results.json; `warnings`: where the tolerance was not met; `seconds`: what the analyses took."""

    rows: list[Numbers] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    seconds: float = 0.0


def in_more_segments(
    project: Project, model: Assembly, demands: Demands, given: Sequence[StateResult], workers: Workers
) -> Estimates:
    """Estimate what segments without end would change; `given`: every state with those given.

    Nothing is done where the project asks for no accuracy, or for no elastic pushover.
    """
    found, tolerance = Estimates(), accuracy_of(project).tolerance
    if tolerance is None or "elastic" not in behaviours(project):
        return found
    rigid = [stage for stage in given if stage.behaviour == "rigid"]  # of one segment, whatever is given
    measured = [measure(project, model, demands, given, QUANTITIES)]
    failed: dict[str, str] = {}
    for times in TIMES:
        stages = analyse_states(_requests(project, finer(model, times)), workers, "segments")
        found.seconds += sum(sum(stage.seconds.values()) for stage in stages)
        failed |= {stage.state: "; ".join(stage.failures) for stage in stages if stage.failures}
        measured.append(measure(project, model, demands, [*rigid, *stages], QUANTITIES))
    for state, ways in measured[0].items():
        for way, numbers in ways.items():
            if numbers["alpha_u"] is None:
                continue  # not reached with the segments given, and said
            levels = Levels(model.size, tuple(level[state][way] for level in measured), result=0)
            found.rows.append({"state": state, "direction": way, **levels.numbers(tolerance)})
            title = f"{state}, {way}"
            if state in failed:
                found.warnings.append(f"{title}: more segments_per_joint fail: {failed[state]}")
            else:
                found.warnings += too_few(title, levels, tolerance)
    return found


def too_few(title: str, levels: Levels, tolerance: float) -> list[str]:
    """Return a warning where the segments given do not meet the tolerance."""
    if levels.within(tolerance):
        return []
    said = "; ".join(levels.missed(tolerance))
    return [
        f"{title}: estimated error of {said} with the segments_per_joint given, "
        f"tolerance {100.0 * tolerance:.2g} %; take more of them"
    ]


def finer(model: Assembly, times: int) -> Assembly:
    """Return the model with so many times the segments in every joint."""
    blocks = [replace(block, segments=block.segments and times * block.segments) for block in model.blocks]
    return replace(model, blocks=blocks, segments_per_joint=times * model.segments_per_joint)


def _requests(project: Project, model: Assembly) -> list[Request]:
    return [Request(project, model, settlement, "elastic") for settlement in (None, *project.settlements)]
