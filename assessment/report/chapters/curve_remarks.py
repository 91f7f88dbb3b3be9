"""Sentences on curves: how one begins, where equilibrium is lost before α = 0, where the fitted one is the higher."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from markupsafe import Markup

from assessment.report.chapters.judgement import ORIGINAL
from assessment.report.tables.curves import alpha_at_d_0, excesses
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.hand_check import mechanisms
from assessment.results.schema import Results
from assessment.results.schema.static import RigidPush

PLACES = 2  # of a displacement in mm: what is less is none that a drawing shows
ONSET = 0.01  # of α_0: an onset below it by more closes hinges first
NEAR = 0.9  # of α_0: an earlier peak above it is reported


def onsets(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each curve that begins, at `alpha_onset`, by closing hinges of the settlement.

    As drawn there are none; blocks that meet others are a warning.
    """
    for name, direction, rigid in sorted(mechanisms(results), key=lambda each: each[1]):
        if name == ORIGINAL or rigid.alpha_onset >= (1.0 - ONSET) * rigid.alpha_0:
            continue
        alpha = rigid.curve.multiplier
        peak = alpha.index(max(alpha))
        yield words(
            "text.onset",
            state=words.state(name),
            direction=direction_name(direction),
            onset=words.show(rigid.alpha_onset),
            least=words.show(min(alpha[: peak + 1])),
            near=_near(rigid, peak, words),
            alpha_0=words.show(rigid.alpha_0),
            place=_place(rigid, peak, words),
        )


def _near(rigid: RigidPush, peak: int, words: Words) -> Markup:
    """Return where the multiplier has come near α_0 before it is largest; nothing where it has not."""
    earlier = _first_peak(rigid.curve.multiplier[: peak + 1])
    if earlier is None:
        return Markup("")
    near = words.show(rigid.curve.multiplier[earlier])
    return words("text.onset_near", near=near, place=_place(rigid, earlier, words))


def _first_peak(alpha: Sequence[float]) -> int | None:
    """Return the first peak of a curve that ends at its largest multiplier and comes near that; None without one."""
    inner = (
        point for point in range(1, len(alpha) - 1) if alpha[point - 1] < alpha[point] > alpha[point + 1]
    )
    return next((point for point in inner if alpha[point] >= NEAR * alpha[-1]), None)


def _place(rigid: RigidPush, point: int, words: Words) -> str:
    place = words.rounded(1000.0 * abs(rigid.curve.displacement_m[point]), PLACES)
    return f"= {place}" if place != "0" else f"< {words.comma(f'{10.0**-PLACES:g}')}"


def lost_before_zero(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the states whose d_0 is not where α vanishes: they lose equilibrium before, at an α that is left."""
    found = [
        words(
            "text.lost_at",
            state=words.state(name),
            direction=direction_name(direction),
            alpha=words.show(left),
        )
        for name, direction, rigid in mechanisms(results)
        if (left := alpha_at_d_0(rigid)) is not None
    ]
    if found:
        yield words("text.lost_before_zero", where=Markup("; ").join(found))


def fitted_above(results: Results, words: Words) -> Iterator[Markup]:
    """Yield where the fitted curve lies far above the elastic one at a displacement that is checked."""
    found = list(excesses(results))
    if not found:
        return
    listed = [
        words(
            "text.fitted_above_at",
            state=words.state(each.state),
            direction=direction_name(each.direction),
            limit=each.limit_state,
            fitted=each.fitted_g,
            elastic=each.elastic_g,
        )
        for each in found
    ]
    least = min(math.sqrt(each.elastic_g / each.fitted_g) for each in found)
    yield words("text.fitted_above", where=Markup("; ").join(listed), factor=words.number(least, 2))
