"""Why runs of an ensemble have no capacity, told once for all of them."""

from __future__ import annotations

from collections.abc import Sequence

from mechanics.messages import Message, message


def towards(direction: str, text: str) -> Message:
    """Return a note on a direction."""
    return message("{direction}: {text}", direction=direction, text=text)


def refused(reason: str) -> Message:
    """Return why there is no capacity."""
    return message("no capacity: {reason}", reason=reason)


def other_mechanism(work: float, alpha: float) -> Message:
    """Return that virtual work gives another multiplier than the curve."""
    return message(
        "virtual work on the mechanism gives α = {work:.3g}, the curve {alpha:.3g}: blocks "
        "slide or move by themselves there, and e*, Γ* are not those of a mechanism",
        work=work,
        alpha=alpha,
    )


TOWARDS, REFUSED = towards("", "").template, refused("").template
OTHER_MECHANISM = other_mechanism(0.0, 0.0).template


def joined(notes: Sequence[Message], runs: int) -> list[Message]:
    """Return the notes of `runs` assessments, those that refuse a direction for one kind of reason as one, others once.

    The joined one says in how many of the runs, and between which values.
    """
    found: dict[object, list[Message]] = {}
    for note in notes:
        found.setdefault(_kind(note), []).append(note)
    return [
        same[0] if runs == 1 or _refusal(same[0]) is None else _told(same, runs) for same in found.values()
    ]


def _refusal(note: Message) -> Message | None:
    """Return why a direction has no capacity; None where a note tells something else."""
    text = note.fields.get("text") if note.template == TOWARDS else None
    if not (isinstance(text, Message) and text.template == REFUSED):
        return None
    reason = text.fields["reason"]
    return reason if isinstance(reason, Message) else None


def _kind(note: Message) -> object:
    """Return the key of a note: notes of the same key are reported as one."""
    reason = _refusal(note)
    return str(note) if reason is None else (str(note.fields["direction"]), reason.template)


def _told(same: Sequence[Message], runs: int) -> Message:
    reasons = [reason for note in same if (reason := _refusal(note)) is not None]
    reason = reasons[0]
    if len(same) > 1 and reason.template == OTHER_MECHANISM:
        work, alpha = ([_number(each, name) for each in reasons] for name in ("work", "alpha"))
        reason = message(
            "virtual work on the mechanism gives α = {least:.3g} to {most:.3g}, the curve {lowest:.3g} to "
            "{highest:.3g}: blocks slide or move by themselves there, and e*, Γ* are not those of a mechanism",
            least=min(work),
            most=max(work),
            lowest=min(alpha),
            highest=max(alpha),
        )
    text = message(
        "no capacity in {count} of {runs} runs: {reason}", count=len(same), runs=runs, reason=reason
    )
    return towards(str(same[0].fields["direction"]), text)


def _number(reason: Message, name: str) -> float:
    value = reason.fields[name]
    assert isinstance(value, int | float)
    return float(value)
