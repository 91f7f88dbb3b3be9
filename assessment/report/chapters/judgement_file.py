"""judgement.md: the drafted judgement as a file that the engineer edits, kept and printed once it was edited."""

from __future__ import annotations

import codecs
import hashlib
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from assessment.report.chapters.judgement import draft_judgement
from assessment.report.text.language import Words, plain_text
from assessment.results.schema import Results
from assessment.runtime.errors import ProjectError

NAME = "judgement.md"
MOST_BYTES = 1_000_000  # of the file: five hundred pages
MARK = re.compile(r"<!-- draft ([0-9a-f]{16})")
TAGS = dict.fromkeys(("h1", "h2", "h4", "h5", "h6"), "h3") | {"strong": "b", "em": "i"}  # those of the report


@dataclass(frozen=True)
class Judgement:
    """`content` of the file; `edited`: the engineer's own words as HTML, None while it is the draft; warnings."""

    content: bytes
    edited: Markup | None
    warnings: tuple[str, ...] = ()


def judgement(results: Results, words: Words, folder: Path) -> Judgement:
    """Return the judgement to write into `folder` beside the results: the draft, or the file there where it was edited.

    The first line of the file holds a digest of the draft that follows: a text that does not match it was edited. Where
    the draft has changed since, a warning says so. Raises ProjectError for a file that cannot be read as text.
    """
    body = "\n".join(f"- {plain_text(sentence)}" for sentence in draft_judgement(results, words)) + "\n"
    mark = f"<!-- draft {_digest(body)}: {words.plain('judgement.file')} -->\n\n"
    path = folder / NAME
    if path.is_file():
        text = read_judgement(path)
        first, _, rest = text.partition("\n")
        found = MARK.match(first)
        written = rest if found else text
        if written.strip() and not (found and found[1] == _digest(written)):
            changed = not found or found[1] != _digest(body)
            notes = (words.plain("warning.judgement", file=NAME),) if changed else ()
            return Judgement(path.read_bytes(), to_html(written), notes)
    return Judgement((mark + body).encode(), None)


def read_judgement(path: Path) -> str:
    """Return the text of the file: UTF-8, or what editors on Windows write, UTF-16 and the code page of the West.

    Raises ProjectError where it is none of them, or longer than anybody writes.
    """
    if path.stat().st_size > MOST_BYTES:
        raise ProjectError(
            f"{path}: more than {MOST_BYTES} bytes; shorten it, or delete it to have a new draft"
        )
    content = path.read_bytes()
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "cp1252"):
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                return "\n".join(text.splitlines()) + "\n"
    raise ProjectError(f"{path}: not readable as text; save it as UTF-8, or delete it to have a new draft")


def refuse_unreadable(folder: Path) -> None:
    """Raise ProjectError, before any analysis, where the file of an output folder is there and cannot be read."""
    if (folder / NAME).is_file():
        read_judgement(folder / NAME)


def to_html(markdown: str) -> Markup:
    """Return paragraphs, headings, lists, **bold** and *italic* text as HTML; everything else is plain text."""
    from markdown_it import MarkdownIt

    parser = MarkdownIt("zero").enable(["heading", "list", "emphasis", "escape", "newline"])
    tokens = parser.parse(without_comments(markdown))
    for block in tokens:
        for token in (block, *(block.children or ())):
            token.tag = TAGS.get(token.tag, token.tag)
    return Markup(parser.renderer.render(tokens, parser.options, {}).rstrip("\n"))


def _digest(body: str) -> str:
    return hashlib.sha256(body.strip().encode()).hexdigest()[:16]


def without_comments(text: str) -> str:
    """Return a text without its <!-- comments -->; one that is not closed stays."""
    kept, begin = [], 0
    while (opened := text.find("<!--", begin)) >= 0 and (closed := text.find("-->", opened + 4)) >= 0:
        kept.append(text[begin:opened])
        begin = closed + 3
    return "".join(kept) + text[begin:]
