"""Sentences on joints: the laws that they obey, and where they are pressed most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from assessment.report.chapters.ties import tie_assumptions
from assessment.report.tables.structure.joints import PRINTED, bounded, crushes, edge_pressures
from assessment.report.text.language import Words
from assessment.results.echo import collisions, coulomb, segments
from assessment.results.schema import Results
from assessment.results.schema.model import Echo


def assumptions(results: Results, words: Words, contacts: Sequence[str]) -> Iterator[Markup]:
    """Yield what the model assumes of blocks, joints, supports and ties; `contacts`: how joints are taken."""
    for key in ("blocks_rigid", "plane", "no_tension"):
        yield words(f"text.{key}")
    yield from joint_law(results, words, "elastic" in contacts)
    yield words("text.supports_rigid")
    yield from tie_assumptions(results, words, contacts)


def joint_law(results: Results, words: Words, elastic: bool) -> Iterator[Markup]:
    """Yield the sentences on joints: how they are found, press, crush, slide and meet; `elastic`: whether any is."""
    yield words("text.joints")
    yield from _bed(results.echo, words) if elastic else [words("text.rigid_joints")]
    strengths = [joint.compressive_strength_kN_m2 for joint in results.geometry.joints]
    limits = sorted({each for each in strengths if each is not None})
    strength = "; ".join(words.number(each) for each in limits)
    key = "no_strength" if not limits else "some_strength" if None in strengths else "strength"
    yield words(f"text.{key}", strength=strength)
    pressed = edge_pressures(results)
    if pressed and bounded(pressed):
        most = pressed[0]
        yield words(
            "text.greatest_pressure",
            pressure=words.number(most.edge_pressure_kN_m2),
            state=words.state(most.state),
            first=most.block_a,
            second=most.block_b,
        )
    yield words("text.sliding_coulomb" if coulomb(results.echo) else "text.sliding")
    yield words("text.collisions" if collisions(results.echo) else "text.no_collisions")


def _bed(echo: Echo, words: Words) -> Iterator[Markup]:
    if found := segments(echo):
        yield words("text.bed_points", segments=", ".join(map(str, found)))
    else:
        yield words("text.bed_exact")


def pressure_sentences(results: Results, words: Words) -> Markup:
    """Return what the table of the report holds, or why it is left out; nothing where no forces are known."""
    found = edge_pressures(results)
    if not found:
        return Markup("")
    if not bounded(found):
        return words("text.unbounded_pressures")
    sentences = [
        words("text.edge_pressures"),
        words("text.edge_pressures_printed", count=PRINTED) if len(found) > PRINTED else "",
        words("text.crushing") if crushes(results) else "",
    ]
    return Markup(" ").join(each for each in sentences if each)
