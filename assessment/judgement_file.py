"""judgement.md: the drafted judgement as a file that the engineer edits, kept and printed once it was edited."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from markupsafe import Markup, escape

from assessment.judgement import draft_judgement
from assessment.table import Results
from assessment.words import Words

NAME = "judgement.md"
MARK = re.compile(r"<!-- draft ([0-9a-f]{16})")
BULLET, HEADING = re.compile(r"[-*] +"), re.compile(r"#+ +")


@dataclass(frozen=True)
class Judgement:
    """`text` of the file to write; `edited`: the engineer's own words as HTML, None while it is the draft; warnings."""

    text: str
    edited: Markup | None
    warnings: tuple[str, ...] = ()


def judgement(results: Results, words: Words, folder: Path) -> Judgement:
    """Return the judgement to write into `folder` beside the results: the draft, or the file there where it was edited.

    The first line of the file holds a digest of the draft that follows: a text that does not match it was edited. Where
    the draft has changed since, a warning says so.
    """
    body = "\n".join(f"- {_plain(sentence)}" for sentence in draft_judgement(results, words)) + "\n"
    mark = f"<!-- draft {_digest(body)}: {words.plain('judgement.file')} -->\n\n"
    path = folder / NAME
    if path.is_file():
        text = path.read_text(encoding="utf-8")
        first, _, rest = text.partition("\n")
        found = MARK.match(first)
        written = rest if found else text
        if written.strip() and not (found and found[1] == _digest(written)):
            changed = not found or found[1] != _digest(body)
            notes = (words.plain("warning.judgement", file=NAME),) if changed else ()
            return Judgement(text, to_html(written), notes)
    return Judgement(mark + body, None)


def to_html(markdown: str) -> Markup:
    """Return paragraphs, headings, bullets, **bold** and *italic* text as HTML; everything else is plain text."""
    return Markup("\n").join(_blocks(_without_comments(markdown).splitlines()))


def _without_comments(text: str) -> str:
    """Leave out what stands between <!-- and -->; one that is not closed is text."""
    first, *others = text.split("<!--")
    kept, open_ = [first], ""
    for part in others:
        open_ += f"<!--{part}"
        _, end, after = part.partition("-->")
        if end:
            kept.append(after)
            open_ = ""
    return "".join(kept) + open_


def _blocks(lines: Iterable[str]) -> Iterator[Markup]:
    def kind(line: str) -> str:
        if HEADING.match(line):
            return "heading"
        return "bullet" if BULLET.match(line) else "text" if line.strip() else "blank"

    for name, group in groupby(_joined(lines), kind):
        if name == "bullet":
            items = (Markup("<li>{}</li>").format(_inline(BULLET.sub("", line, count=1))) for line in group)
            yield Markup("<ul>{}</ul>").format(Markup("").join(items))
        elif name == "heading":
            for line in group:
                yield Markup("<h3>{}</h3>").format(_inline(HEADING.sub("", line, count=1)))
        elif name == "text":
            yield Markup("<p>{}</p>").format(_inline(" ".join(group)))


def _joined(lines: Iterable[str]) -> Iterator[str]:
    """Join the indented lines that continue a bullet to it."""
    parts: list[str] = []
    for line in lines:
        if parts and BULLET.match(parts[0]) and line.startswith(" ") and line.strip():
            parts.append(line.strip())
            continue
        if parts:
            yield " ".join(parts)
        parts = [line]
    if parts:
        yield " ".join(parts)


def _inline(text: str) -> Markup:
    html = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", str(escape(text.strip())))
    return Markup(re.sub(r"\*(.+?)\*", r"<i>\1</i>", html))


def _plain(sentence: Markup) -> str:
    """Return a sentence of the draft without HTML: subscripts after an underscore."""
    return Markup(re.sub(r"<sub>(.*?)</sub>", r"_\1", str(sentence))).striptags()


def _digest(body: str) -> str:
    return hashlib.sha256(body.strip().encode()).hexdigest()[:16]
