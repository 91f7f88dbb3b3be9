"""Contradictions in the structure and its static analyses: loads, stiffness, control points, settlements."""

from __future__ import annotations

import math
from collections.abc import Iterator

from assessment.ntc.load_factors import OWN_PSI_2, PSI_2
from assessment.project.consistency.names import unknown_name
from assessment.project.errors import Problem, key_of
from assessment.project.schema import (
    ORIGINAL,
    KeyPath,
    LayerTable,
    MotionTable,
    ProjectContent,
    SettlementTable,
)

_MOST_INCREMENTS = 100_000
LEAST_MOVEMENT = 1e-7
"""Movements below it, m and rad, are slips of the unit, and no longer told from rounding."""


def load_problems(path: KeyPath, layer: LayerTable) -> Iterator[Problem]:
    """Yield a problem for upward loads with mass, and for variable loads without ψ₂ (NTC 2018, §2.5.3, Tab. 2.5.I)."""
    if layer.vertical_load_kN < 0.0 and layer.load_has_mass:
        text = f"{layer.vertical_load_kN:g} acts upward and has no mass; add load_has_mass = false"
        yield Problem((*path, "vertical_load_kN"), text)
    category, psi_2 = layer.use_category, layer.psi_2
    if layer.variable_load_kN == 0.0:
        for key in ("use_category", "psi_2"):
            if getattr(layer, key) is not None:
                yield Problem((*path, key), "there is no variable load; add variable_load_kN or leave it out")
    elif psi_2 is None and category is None:
        text = "ψ₂ is not known; add use_category (NTC 2018, Tab. 2.5.I), or psi_2"
        yield Problem((*path, "variable_load_kN"), text)
    elif psi_2 is None and category in OWN_PSI_2:
        text = f"{category} has no ψ₂ in NTC 2018, Tab. 2.5.I, it is to be judged case by case; add psi_2"
        yield Problem((*path, "use_category"), text)
    elif psi_2 is not None and PSI_2.get(category or "", psi_2) != psi_2:
        text = (
            f'{psi_2:g}, but use_category = "{category}" has {PSI_2[category or ""]:g}; leave one of them out'
        )
        yield Problem((*path, "psi_2"), text)


def stiffness_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem if an analysis is elastic and no layer has a stiffness.

    Single blocks without a stiffness are found when the model is built.
    """
    layers = project.layers.values()
    if project.material.normal_stiffness_kN_m3 or any(layer.normal_stiffness_kN_m3 for layer in layers):
        return
    pushover, incremental, assessment = project.pushover, project.incremental, project.assessment
    needed_by = [
        f"history[{n}].contacts" for n, each in enumerate(project.history, 1) if each.contacts == "elastic"
    ]
    if pushover and "elastic" in pushover.contacts:
        needed_by.append("pushover.contacts")
    if incremental and incremental.contacts == "elastic":
        needed_by.append("incremental.contacts")
    if project.campaign and project.campaign.contacts == "elastic":
        needed_by.append("campaign.contacts")
    if assessment and assessment.model != "none":
        needed_by.append("assessment.model")
    if needed_by:
        text = (
            f"missing, but {', '.join(needed_by)} ask for elastic contacts; add it, in kN/m³ "
            '(or write contacts "rigid", model "none")'
        )
        yield Problem(("material", "normal_stiffness_kN_m3"), text)


def crushing_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem where joints of motions are rigid and have a compressive strength: see `time_history`."""
    strengths: list[float | None] = [project.material.compressive_strength_kN_m2]
    strengths += [layer.compressive_strength_kN_m2 for layer in project.layers.values()]
    for each in project.strengthening:
        strengths += [layer.compressive_strength_kN_m2 for layer in each.layers.values()]
    if not any(strength is not None and strength < math.inf for strength in strengths):
        return
    motions: list[tuple[KeyPath, MotionTable]] = [
        (("history", index), motion) for index, motion in enumerate(project.history)
    ]
    motions += [(("incremental",), project.incremental)] if project.incremental else []
    motions += [(("campaign",), project.campaign)] if project.campaign else []
    rigid: list[KeyPath] = [(*path, "contacts") for path, motion in motions if motion.contacts == "rigid"]
    if rigid:
        also = f" (also {', '.join(map(key_of, rigid[1:]))})" if rigid[1:] else ""
        text = (
            f'"rigid" joints do not remember in a motion what was crushed{also}; write "elastic", with '
            "normal_stiffness_kN_m3, or leave compressive_strength_kN_m2 out, with confidence_factor = 1.35"
        )
        yield Problem(rigid[0], text)


def control_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem for each reference to a control point that does not exist."""
    references: list[tuple[KeyPath, str | None]] = [
        (("history", index, "control"), motion.control) for index, motion in enumerate(project.history)
    ]
    if project.pushover:
        control = project.pushover.control
        by_key = control.items() if isinstance(control, dict) else ()
        references += [(("pushover", "control", direction), name) for direction, name in by_key]
        references += [(("pushover", "control"), control)] if isinstance(control, str) else []
    if project.incremental:
        references.append((("incremental", "control"), project.incremental.control))
    if project.campaign:
        references.append((("campaign", "control"), project.campaign.control))
    for path, name in references:
        if name is not None:
            yield from unknown_name(path, name, [point.name for point in project.control], "control point")


def movement(settlement: SettlementTable) -> float:
    """Return the largest of the components of a movement (m) and its rotation (rad)."""
    return max(*map(abs, settlement.displacement_m), abs(settlement.rotation_rad))


def settlement_problems(
    project: ProjectContent, path: KeyPath, settlement: SettlementTable
) -> Iterator[Problem]:
    """Yield a problem for each key of a settlement that is wrong: name, support, movement (m, rad), increments."""
    if settlement.name == ORIGINAL:
        yield Problem((*path, "name"), f'"{ORIGINAL}" is the state before any settlement; write another name')
    yield from unknown_name((*path, "support"), settlement.support, project.supports, "support")
    yield from _after_problems(project, path, settlement)
    largest = max(map(abs, settlement.displacement_m))
    if largest == 0.0 and settlement.rotation_rad == 0.0:
        yield Problem((*path, "displacement_m"), "nothing moves; write a displacement or a rotation_rad")
    elif (least := movement(settlement) / (settlement.steps or 1)) < LEAST_MOVEMENT:
        text = f"{least:g} m (or rad) moves nothing; write {LEAST_MOVEMENT:g} or more"
        yield Problem((*path, "displacement_m"), text if settlement.steps is None else f"in steps, {text}")
    elif "increment_m" in settlement.model_fields_set and settlement.increment_m > largest > 0.0:
        text = f"{settlement.increment_m:g} is larger than the movement; write {largest:g} or less"
        yield Problem((*path, "increment_m"), text)
    if settlement.increments > _MOST_INCREMENTS:
        text = (
            f"the movement takes {settlement.increments} increments; "
            f"write longer ones, for {_MOST_INCREMENTS} or fewer"
        )
        turns = abs(settlement.rotation_rad) / settlement.increment_rad > largest / settlement.increment_m
        yield Problem((*path, "increment_rad" if turns else "increment_m"), text)
    if settlement.steps and not project.pushover:
        text = "there is no pushover whose capacity could be reviewed; add [pushover] or leave steps out"
        yield Problem((*path, "steps"), text)


def _after_problems(project: ProjectContent, path: KeyPath, settlement: SettlementTable) -> Iterator[Problem]:
    """Yield a problem where a movement begins in no state, in its own, or in one of other ties; or is swept."""
    if settlement.after is None:
        return
    key: KeyPath = (*path, "after")
    yield from unknown_name(key, settlement.after, project.unstrengthened[1:], "settlement")
    if settlement.after in project.unstrengthened[1:]:
        movements = project.movements_to(settlement.name)
        if movements[0].after is not None:
            yield Problem(key, "the movements begin in each other's states; let one of them begin as drawn")
            return
        there, before = (project.ties_of(name)[0] for name in (settlement.name, settlement.after))
        for tie in (each for each in project.tie if (each in there) != (each in before)):
            text = (
                f'the tie "{tie.name}" is there in one of "{settlement.after}" and "{settlement.name}" alone'
            )
            yield Problem(key, f"{text}; write both in its states, or none")
    if settlement.steps:
        text = "capacities after parts of a movement are those of one that begins as drawn; leave it out"
        yield Problem((*path, "steps"), text)
    campaign = project.campaign
    if campaign and settlement.name in (campaign.settlements or project.unstrengthened):
        text = f'shares of a movement begin as drawn, "{settlement.name}" does not; write the names of others'
        yield Problem(("campaign", "settlements"), text)
