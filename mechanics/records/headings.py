"""What a heading says of a column: its quantity and its unit, whichever way they are spelt, in English or Italian."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Literal

from mechanics.errors import RecordError
from mechanics.types import GRAVITY

Quantity = Literal["time", "acceleration", "velocity", "displacement", "count"]

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "ft": 0.3048, "in": 0.0254}  # m
ACCELERATIONS = {"g": 1.0, "% g": 0.01, "mg": 1e-3, "gal": 0.01 / GRAVITY, "mgal": 1e-5 / GRAVITY} | {
    f"{unit}/s²": size / GRAVITY for unit, size in LENGTHS.items()
}  # in g
TIMES = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0}  # s
KNOWN = f"known are {', '.join(ACCELERATIONS)}"


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


QUANTITIES: dict[Quantity, frozenset[str]] = {
    "time": _set("t time times tempo tempi temps tiempo istante"),
    "acceleration": _set(
        "a acc accel acceleration accelerations accelaration accelerogram accelerazione accelerazioni accelerogramma "
        "aceleracion ag agx agy agz ax ay az accx accy accz"
    ),
    "velocity": _set("v vel velocity velocities velocita vitesse velocidad vx vy vz"),
    "displacement": _set(
        "d u disp displ displacement displacements spostamento spostamenti deplacement dx dy dz"
    ),
    "count": _set("no nr num index indice id sample samples point points step campione passo"),
}
OTHER = _set(  # words of a heading that change neither quantity nor unit
    "x y z ns ew sn we ud up h1 h2 hne hnn hnz n e w north south east west nord sud est ovest horizontal vertical "
    "orizzontale verticale component comp componente dir direction direzione channel ch canale ground soil suolo "
    "terreno motion moto base input record registrazione corrected corretta corretto filtered filtrata history "
    "series storia serie data dati value values valore valori in of di del unit units unita"
)
WORDS = {  # of units, as they are written out
    r"(milli)(metres?|meters?|metri|metro)": "mm",
    r"(centi)(metres?|meters?|metri|metro)": "cm",
    r"metres?|meters?|metri|metro": "m",
    r"feet|foot|piedi|piede": "ft",
    r"inch(es)?|pollici|pollice": "in",
    r"milliseconds?|millisecondi|millisecondo|msecs?": "ms",
    r"seconds?|secondi|secondo|secs?": "s",
    r"minutes?|minuti|minuto": "min",
    r"squared|al quadrato|quadrato|quadri": "2",
    r"per cento|percent|per cent": "%",
    r"per|al": "/",
    r"gals": "gal",
    r"gs|g's|gravity": "g",
    r"of": "",
}
LENGTH = "(?P<length>mm|cm|dm|m|ft|in)"
ACCELERATION = re.compile(rf"{LENGTH}(/s/?-?2|/s/s|/ss|s-?2|ps2|pss|ps/s)")
VELOCITY = re.compile(rf"{LENGTH}(/s|s-1|ps)|kines?")
# a word that no unit goes on from
WORD = re.compile(r"[\s\-–:=,;.#'\"]*([a-z]+\d?)(?![\w%/^²'’])(?!\s*[/^])")
SPEAKS_OF_UNITS = re.compile(
    r"\b(mm|cm|m|ft|in)\s*[/·*.]?\s*s(ec)?(?![a-z])|\bgals?\b|%\s*g\b|\bm?g\b|\bunits?\b|\bunita\b|\bdt\b|\bhz\b"
    r"|\bstep|\bpasso|interval|sampl|frequen|campion|velocit|displacement|spostament"
)
BRACKETS = re.compile(r"(?<!/)[(\[]([^()\[\]]*(?:\([^()]*\)[^()\[\]]*)*)[)\]]")


class HeadingError(RecordError):
    """A heading that is not understood, or says what is no acceleration; the message tells which words."""


@dataclass(frozen=True)
class Column:
    """What a column holds: `size` of its unit in g or s."""

    quantity: Quantity
    unit: str
    size: float


def unit(text: str) -> Column | None:
    """Return the unit that a text is; None: unknown. Those of velocity and displacement, to be refused, have size 0."""
    plain = _plain(text).replace("_", " ").strip(" .,;:")
    plain = re.sub(r"^(in|units?|unita)\s+((of|di)\s+)?", "", plain)
    for words, symbol in WORDS.items():
        plain = re.sub(rf"(?<![a-z])(?:{words})(?![a-z])", symbol, plain)
    compact = re.sub(r"[\s*^().·⋅×]", "", plain.replace("µ", "u").replace("μ", "u"))
    compact = compact.replace("sqs", "s2").replace("ssq", "s2").replace("sec", "s")
    named = {"%g": "% g", "g%": "% g", "us": "µs"}.get(compact, compact)
    if named in ACCELERATIONS:
        return Column("acceleration", named, ACCELERATIONS[named])
    if match := ACCELERATION.fullmatch(compact):
        name = f"{match['length']}/s²"
        return Column("acceleration", name, ACCELERATIONS[name])
    if named in TIMES:
        return Column("time", named, TIMES[named])
    if VELOCITY.fullmatch(compact):
        return Column("velocity", compact, 0.0)
    return Column("displacement", compact, 0.0) if compact in LENGTHS else None


def column(label: str) -> Column:
    """Return what the label of a column says; accelerations without a unit are in g, times in s.

    Raises HeadingError for a label of which any part is not understood: what a file says is not passed over.
    """
    label = re.sub(r"[{}$]", "", label)
    bracketed = [match[1] for match in BRACKETS.finditer(label)]
    words, rest = _words(BRACKETS.sub(" ", label))
    quantities = {name for name, own in QUANTITIES.items() if own & set(words)}
    units = [] if not rest else [(rest, unit(rest))]
    for text in bracketed:
        own = unit(text)
        inner, left = _words(text)
        if own is None and not left:
            quantities |= {name for name, known in QUANTITIES.items() if known & set(inner)}
        else:
            units.append((text, own))
    found: set[Column] = set()
    for text, own in units:
        if own is None:
            raise HeadingError(f"{text.strip()!r} in the heading {label.strip()!r} is no unit that is known")
        found.add(own)
    quantities |= {own.quantity for own in found}
    if len(quantities) > 1:
        raise HeadingError(f"the heading {label.strip()!r} says {' and '.join(sorted(quantities))}")
    if len({round(own.size, 12) for own in found}) > 1:
        raise HeadingError(f"the heading {label.strip()!r} gives two units")
    if found:
        return found.pop()
    if bracketed and quantities == {"time"}:  # "ns" is north-south of an acceleration, and nothing of a time
        raise HeadingError(f"{bracketed[0]!r} in the heading {label.strip()!r} is no unit that is known")
    if not words and label.strip("# "):
        raise HeadingError(f"the heading {label.strip()!r} names no quantity")
    quantity: Quantity = next(iter(quantities), "acceleration" if words else "count")
    bare: dict[Quantity, tuple[str, float]] = {"time": ("s", 1.0), "acceleration": ("g", 1.0)}
    return Column(quantity, *bare.get(quantity, ("", 0.0)))


def labels(heading: str, count: int, separator: str | None) -> list[str]:
    """Part a heading into `count` labels, as the numbers below it are. Raises HeadingError for another number."""
    if count == 1:
        return [heading]
    for form in [re.escape(separator)] if separator else [r"\t+", r"\s{2,}", r"[;,]", r"\s+"]:
        parts = re.split(form, heading.strip())
        while len(parts) > count and not parts[-1].strip():
            parts.pop()
        if len(parts) == count:
            return parts
    plain, names = _plain(heading), "|".join(sorted(set().union(*QUANTITIES.values()), key=len, reverse=True))
    starts = [match.start() for match in re.finditer(rf"(?<![\w/])({names})(?![a-z])", plain)]
    if len(starts) == count and not plain[: starts[0]].strip():
        return [plain[a:b] for a, b in zip(starts, [*starts[1:], len(plain)], strict=True)]
    raise HeadingError(f"the heading {heading!r} does not name {count} columns")


def speaks_of_units(text: str) -> bool:
    """Whether a line of comment says something about units or time steps that a reader must not pass over."""
    return bool(SPEAKS_OF_UNITS.search(_plain(text)))


def _words(text: str) -> tuple[list[str], str]:
    """Return the words before the unit of a label, and what is left after them."""
    plain = re.sub(r"\ba_g\b", "ag", _plain(text)).replace("_", " ")
    known = OTHER.union(*QUANTITIES.values())
    words: list[str] = []
    while match := WORD.match(plain):
        word = match[1] if match[1] in known else match[1].rstrip("0123456789")
        if word not in known or (word == "in" and words and unit(plain[match.end() :]) is None):
            break
        words.append(word)
        plain = plain[match.end() :]
    return words, plain.strip(" -–:=,;.#'\"")


def _plain(text: str) -> str:
    """Return a text in lower case, with superscripts as digits and without accents."""
    spread = unicodedata.normalize("NFKD", text.replace("µ", "μ"))
    return "".join(c for c in spread if not unicodedata.combining(c)).lower().replace("\u2212", "-")
