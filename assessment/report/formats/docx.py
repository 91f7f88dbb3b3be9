"""The report as a Word document: the page of the report, element by element, in styles that an office can change.

Nothing is worded here: headings, paragraphs, lists, tables and figures are those of the HTML that the PDF is made of.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docx import Document
from docx.enum.section import WD_SECTION
from docx.shared import Emu, Mm
from docx.text.paragraph import Paragraph
from lxml import html

from assessment.report.formats import docx_styles as styles

Element = Any  # of lxml, which has no types
HEADINGS = {"h2": "Heading 1", "h3": "Heading 2"}
FORMATS = {
    "b": "bold",
    "strong": "bold",
    "i": "italic",
    "em": "italic",
    "sub": "subscript",
    "sup": "superscript",
}
HIGHEST = Mm(165)  # of a picture: its caption stands on the same page
MADE = (1980, 1, 1, 0, 0, 0)  # of every part of the file: the same report has the same bytes
SPACES = re.compile(r"[ \t\r\n]+")  # those of HTML: a blank between a number and its unit stays one


def to_docx(page: str, folder: Path) -> bytes:
    """Return the report as the bytes of a .docx file.

    `page`: its HTML; `folder`: where the PNG or JPEG files are that figures name in their `data-file`.
    """
    root = html.document_fromstring(page, parser=html.HTMLParser(huge_tree=True))
    document = Document()
    styles.prepare(document, root.get("lang"))
    _properties(document, root)
    _cover(document, root.find_class("cover")[0])
    _contents(document, root.find(".//nav"))
    for element in root.find(".//main"):
        _block(document, element, folder)
    return _same_bytes(document)


def _properties(document: Any, root: Element) -> None:
    """Fill in what Word shows of the file: title, author and program; no date, which would differ every time."""
    about = {each.get("name"): each.get("content") for each in root.iterfind(".//meta[@name]")}
    properties = document.core_properties
    properties.title = root.findtext(".//title")
    properties.author = about.get("author", "")
    properties.comments = about.get("generator", "")
    properties.language = root.get("lang")


def _cover(document: Any, cover: Element) -> None:
    """Write the title page as a section of its own, without the running heads of the pages that follow."""
    for element in cover:
        if element.tag == "h1":
            _words(styles.paragraph(document, "Title"), element)
        elif element.tag == "p":
            _words(styles.paragraph(document, "Subtitle"), element)
        else:
            _table(document, element)
    title = cover.findtext(".//h1")
    subtitle, program = (cover.find_class(name)[0].text_content() for name in ("subtitle", "program"))
    styles.running_heads(document.add_section(WD_SECTION.NEW_PAGE), title, subtitle, program)


def _contents(document: Any, nav: Element) -> None:
    """Write the contents: the chapters, and the pages on which the program that shows the document has them."""
    styles.paragraph(document, styles.CONTENTS_HEADING).add_run(nav.findtext("h2"))
    styles.contents(document, {each.get("href")[1:]: each.text_content() for each in nav.iterfind(".//a")})
    document.add_page_break()


def _block(document: Any, element: Element, folder: Path) -> None:
    """Write an element of the report's body."""
    if element.tag in HEADINGS:
        heading = styles.paragraph(document, HEADINGS[element.tag])
        _words(heading, element)
        if (name := element.get("id")) is not None:
            styles.named(heading, name, len(document.element.body))
    elif element.tag == "p":
        _words(styles.paragraph(document, "Quote" if "draft" in element.classes else "Body Text"), element)
    elif element.tag in {"ul", "ol"}:
        for item in element.iterfind("li"):
            _words(styles.paragraph(document, "List Bullet"), item)
    elif element.tag == "figure":
        _figure(document, element, folder)
    elif element.tag == "table":
        _table(document, element)
    else:  # a division
        for inner in element.iterchildren(tag=html.etree.Element):
            _block(document, inner, folder)


def _figure(document: Any, figure: Element, folder: Path) -> None:
    image = figure.find("img")
    place = styles.paragraph(document, styles.FIGURE)
    shape = place.add_run().add_picture(str(folder / image.get("data-file")))
    shrink = min(1.0, styles.WIDTH / shape.width, HIGHEST / shape.height)
    shape.width, shape.height = Emu(round(shape.width * shrink)), Emu(round(shape.height * shrink))
    shape._inline.docPr.set("descr", image.get("alt"))  # what a screen reader says
    _words(styles.paragraph(document, "Caption"), figure.find("figcaption"))


def _table(document: Any, table: Element) -> None:
    """Write a table with its caption above; heads are repeated on every page, numbers stand at the right."""
    if (caption := table.find("caption")) is not None:
        _words(styles.paragraph(document, styles.TABLE_CAPTION), caption)
    rows = [list(row) for row in table.iter("tr")]
    headed = table.find("thead") is not None
    native = document.add_table(
        len(rows), max(map(len, rows)), style=styles.TABLE if headed else "Normal Table"
    )
    native.autofit = False
    texts = [[SPACES.sub(" ", cell.text_content()).strip() for cell in cells] for cells in rows]
    widths = styles.widths(texts) if headed else [Emu(round(styles.WIDTH * share)) for share in (0.3, 0.7)]
    for column, width in zip(native.columns, widths, strict=True):
        column.width = width
    small = headed and len(widths) > styles.MANY_COLUMNS
    kept = styles.kept_with_next(texts, widths) if headed else ()
    for number, (row, cells) in enumerate(zip(native.rows, rows, strict=True)):
        styles.keep_whole(row, head=headed and number == 0)
        for cell, width, source in zip(row.cells, widths, cells, strict=True):
            cell.width = width
            named = number == 0 and headed
            paragraph = cell.paragraphs[0]
            styles.apply(
                paragraph, styles.TABLE_HEAD if named else styles.SMALL_TEXT if small else styles.TABLE_TEXT
            )
            if headed and "text" not in source.classes:
                paragraph.alignment = styles.RIGHT
            if "blank" in source.classes:
                styles.ruled(cell)
            if "tall" in source.classes:
                row.height = styles.STAMP
            if number in kept:
                paragraph.paragraph_format.keep_with_next = True
            _words(paragraph, source)
    styles.paragraph(document, styles.AFTER_TABLE)


def _words(paragraph: Paragraph, element: Element) -> None:
    """Write the text of an element, its subscripts, superscripts, bold and italic words in runs of their own."""
    pieces = [(SPACES.sub(" ", text), formats) for text, formats in _runs(element, frozenset())]
    for number, (text, formats) in enumerate(pieces):
        shown = text.lstrip(" ") if number == 0 else text
        run = paragraph.add_run(shown.rstrip(" ") if number == len(pieces) - 1 else shown)
        for name in formats:
            setattr(run.font, name, True)


def _runs(element: Element, formats: frozenset[str]) -> Iterator[tuple[str, frozenset[str]]]:
    own = formats | {FORMATS[element.tag]} if element.tag in FORMATS else formats
    if element.text:
        yield element.text, own
    for inner in element.iterchildren(tag=html.etree.Element):
        yield from _runs(inner, own)
        if inner.tail:
            yield inner.tail, own


def _same_bytes(document: Any) -> bytes:
    """Return the file with the same date on all of its parts."""
    made, file = io.BytesIO(), io.BytesIO()
    document.save(made)
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as new:
        for part in old.infolist():
            new.writestr(zipfile.ZipInfo(part.filename, MADE), old.read(part), zipfile.ZIP_DEFLATED)
    return file.getvalue()
