"""What the reader of an identification has to know, as sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce

import numpy as np

from assessment.results.schema.studies import Explanation, Identification
from assessment.studies.identification.unknowns import Unknowns
from mechanics.messages import Message, headed, message
from mechanics.types import Array, Mask

UNLIKELY = 0.01  # probability of a χ² as large, below which a hypothesis does not explain the measurements
IN_IT = 0.3  # of a unit vector: a component that takes part in a movement that is not determined


def open_movements(unknowns: Unknowns, directions: Array) -> list[Message]:
    """Return the movements that are not determined, of unit vectors (d, n) at right angles, in words.

    Components that are free by themselves stand alone; of the others those stand together that can change together.
    """
    free = np.linalg.norm(directions, axis=0) > np.sqrt(1.0 - IN_IT**2)
    alone = [_component(*unknowns.components[k]) for k in np.flatnonzero(free)]
    together = np.linalg.svd(np.where(free, 0.0, directions))[2][: len(directions) - len(alone)]
    return [*alone, *(_together(unknowns, direction) for direction in together)]


def kinked_components(unknowns: Unknowns, kinked: Mask) -> list[Message]:
    """Return the components (n, 2) whose prediction has a kink within a standard error, below or above, in words."""
    found = []
    for each, (below, above) in zip(unknowns.components, kinked.tolist(), strict=True):
        component = _component(*each)
        if below and above:
            found.append(message("{component}, on both sides", component=component))
        elif below:
            found.append(message("{component}, towards lower values", component=component))
        elif above:
            found.append(message("{component}, towards higher values", component=component))
    return found


def _together(unknowns: Unknowns, direction: Array) -> Message:
    """Return the components that can change together along a direction (n,)."""
    parts = [
        _component(support, name)
        for (support, name), part in zip(unknowns.components, direction, strict=True)
        if abs(part) > IN_IT
    ]
    return reduce(
        lambda first, second: message("{first} together with {second}", first=first, second=second), parts
    )


def _component(support: str, name: str) -> Message:
    if name == "x":
        return message("the movement along x of the support {name}", name=support)
    if name == "z":
        return message("the movement along z of the support {name}", name=support)
    return message("the rotation of the support {name}", name=support)


def findings(found: Identification) -> list[Message]:
    """Return what is not determined, what contradicts, and which hypotheses are not told from each other."""
    return [
        *(
            headed(message("identification, {hypothesis}", hypothesis=each.hypothesis), text)
            for each in found.hypotheses
            for text in _of_hypothesis(each)
        ),
        *_alike(found),
    ]


def not_followed(unknowns: Unknowns, reasons: Sequence[Message]) -> list[Message]:
    """Return that paths of a hypothesis were stopped by other errors than a collapse, and the first `reasons`."""
    if not reasons:
        return []
    text = message(
        "{count} movements that were tried could not be followed to their end, for another reason than a collapse; a "
        "better fit may lie there; the first: {reason}",
        count=len(reasons),
        reason=reasons[0],
    )
    return [headed(message("identification, {hypothesis}", hypothesis=unknowns.title), text)]


def _of_hypothesis(each: Explanation) -> Iterator[Message]:
    """Yield what is to be known of a hypothesis; of one that another explains far better, no more than that."""
    if each.chi_squared is None:
        yield message("no movement could be followed")
        return
    if each.probability is not None and each.probability < UNLIKELY:
        yield message(
            "the movement does not explain the measurements: a χ² of {square:.3g} or more has a probability of "
            "{probability:.2g}",
            square=each.chi_squared,
            probability=each.probability,
        )
    if each.distinguished:
        return
    if each.degrees_of_freedom == 0:
        yield message(
            "as many unknowns as measurements: nothing is left by which the fit could be judged; measure more"
        )
    for text in each.undetermined:
        yield message("the measurements do not determine {text}; measure where it shows", text=text)
    for text in each.kinked:
        yield message(
            "the prediction has a kink within a standard error of {component}: hinges move to other joints there, and "
            "the standard error holds up to there",
            component=text,
        )
    for row in each.fit:
        if row.measurement in each.contradicting:
            yield message(
                "the measurement {name} contradicts the rest: predicted {predicted:.3g} {unit}, measured "
                "{measured:.3g} ± {sigma:.3g} {unit}",
                name=row.measurement,
                predicted=row.predicted,
                measured=row.measured,
                sigma=row.sigma,
                unit=row.unit,
            )
    if each.at_collapse:
        yield message("the fit would improve beyond what the structure survives")


def _alike(found: Identification) -> Iterator[Message]:
    if found.best is None:
        return
    best = found.hypotheses[found.best]
    for each in found.hypotheses:
        if each is not best and not each.distinguished:
            yield message(
                "identification: the measurements do not tell one hypothesis ({first}) from another ({second}): their "
                "AIC differ by less than 2",
                first=best.hypothesis,
                second=each.hypothesis,
            )
