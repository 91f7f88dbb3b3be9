"""The report as a Word document: the HTML that the PDF is made of, element by element, worded there.

Every look is a named style of `templates/docx_styles.xml`, which an office can change.
"""

import io
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docx import Document
from docx.enum.section import WD_SECTION
from docx.enum.text import WD_ALIGN_PARAGRAPH, WD_TAB_ALIGNMENT, WD_TAB_LEADER
from docx.oxml import parse_xml
from docx.oxml.ns import nsdecls
from docx.shared import Emu, Mm
from docx.text.paragraph import Paragraph
from lxml import html
from markupsafe import escape

from assessment.runtime.files import template

Element = Any  # of lxml, which has no types
HEADINGS = {"h2": "Heading 1", "h3": "Heading 2"}
FORMATS = {
    "b": "bold", "strong": "bold", "i": "italic", "em": "italic", "sub": "subscript", "sup": "superscript",
}  # fmt: skip
LOCALES = {"it": "it-IT", "en": "en-GB"}
PAGE, MARGIN, HEAD = (Mm(210), Mm(297)), Mm(20), Mm(24)
WIDTH = PAGE[0] - 2 * MARGIN
HIGHEST = Mm(165)  # of a picture: its caption stands on the same page
# rows of a table that stands on one page; at the head and at the end of a longer one, that stand together
WHOLE, TOGETHER = 20, 3
STAMP = Mm(22)  # of height, for a stamp and a signature
MANY_COLUMNS = 9  # of a table: its text is smaller from there on
MADE = (1980, 1, 1, 0, 0, 0)  # of every part of the file: the same report has the same bytes
SPACES = re.compile(r"[ \t\r\n]+")  # those of HTML: a blank between a number and its unit stays one


def to_docx(page: str, folder: Path) -> bytes:
    """Return the report as the bytes of a .docx file.

    `page`: its HTML; `folder`: where the PNG or JPEG files are that figures name in their `data-file`.
    """
    root = html.document_fromstring(page, parser=html.HTMLParser(huge_tree=True))
    document: Any = Document()
    styles = template("docx_styles.xml")
    document.styles.element[:] = parse_xml(styles.replace("LOCALE", LOCALES[root.get("lang")]))[:]
    section = document.sections[0]
    section.page_width, section.page_height = PAGE
    section.left_margin = section.right_margin = section.bottom_margin = MARGIN
    section.top_margin = HEAD
    about = {each.get("name"): each.get("content") for each in root.iterfind(".//meta[@name]")}
    properties = document.core_properties  # no date, which would differ every time
    properties.title, properties.language = root.findtext(".//title"), root.get("lang")
    properties.author, properties.comments = about.get("author", ""), about.get("generator", "")
    # the title page, and the running heads of the section that follows: title above, page number below
    cover = root.find_class("cover")[0]
    for element in cover:
        if element.tag == "table":
            _table(document, element)
        else:
            _words(_paragraph(document, "Title" if element.tag == "h1" else "Subtitle"), element)
    subtitle, program = (cover.find_class(name)[0].text_content() for name in ("subtitle", "program"))
    section = document.add_section(WD_SECTION.NEW_PAGE)
    heads = (section.header, cover.findtext(".//h1"), subtitle), (section.footer, program, "")
    for part, left, right in heads:
        part.is_linked_to_previous = False
        part.paragraphs[0].text = f"{left}\t{right}"
        part.paragraphs[0].paragraph_format.tab_stops.add_tab_stop(WIDTH, WD_TAB_ALIGNMENT.RIGHT)
    _append(section.footer.paragraphs[0]._p, "fldSimple", 'w:instr="PAGE"', "<w:r><w:t>1</w:t></w:r>")
    # the chapters, and the pages on which the program that shows the document has them
    nav = root.find(".//nav")
    _paragraph(document, "Contents Heading").add_run(nav.findtext("h2"))
    for link in nav.iterfind(".//a"):
        line = _paragraph(document, "toc 1")
        line.paragraph_format.tab_stops.add_tab_stop(WIDTH, WD_TAB_ALIGNMENT.RIGHT, WD_TAB_LEADER.DOTS)
        line.add_run(f"{link.text_content()}\t")
        field = f'w:instr="PAGEREF _{escape(link.get("href")[1:])} \\h" w:dirty="true"'
        _append(line._p, "fldSimple", field, "<w:r><w:t>–</w:t></w:r>")
    document.add_page_break()
    for element in root.find(".//main"):
        _block(document, element, folder)
    made, file = io.BytesIO(), io.BytesIO()
    document.save(made)
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as new:
        for part in old.infolist():
            new.writestr(zipfile.ZipInfo(part.filename, MADE), old.read(part), zipfile.ZIP_DEFLATED)
    return file.getvalue()


def _block(document: Any, element: Element, folder: Path) -> None:
    if element.tag in HEADINGS:
        heading = _paragraph(document, HEADINGS[element.tag])
        _words(heading, element)
        if (name := element.get("id")) is not None:  # by which the contents know it
            number = len(document.element.body)
            _append(heading._p, "bookmarkStart", f'w:id="{number}" w:name="_{escape(name)}"')
            _append(heading._p, "bookmarkEnd", f'w:id="{number}"')
    elif element.tag == "p":
        _words(_paragraph(document, "Quote" if "draft" in element.classes else "Body Text"), element)
    elif element.tag in {"ul", "ol"}:
        for item in element.iterfind("li"):
            _words(_paragraph(document, "List Bullet"), item)
    elif element.tag == "figure":
        image = element.find("img")
        shape = _paragraph(document, "Figure").add_run().add_picture(str(folder / image.get("data-file")))
        shrink = min(1.0, WIDTH / shape.width, HIGHEST / shape.height)
        shape.width, shape.height = Emu(round(shape.width * shrink)), Emu(round(shape.height * shrink))
        shape._inline.docPr.set("descr", image.get("alt"))  # what a screen reader says
        _words(_paragraph(document, "Caption"), element.find("figcaption"))
    elif element.tag == "table":
        _table(document, element)
    else:  # a division
        for inner in element.iterchildren(tag=html.etree.Element):
            _block(document, inner, folder)


def _table(document: Any, table: Element) -> None:
    """Write a table with its caption above; heads are repeated on every page, numbers stand at the right."""
    if (caption := table.find("caption")) is not None:
        _words(_paragraph(document, "Table Caption"), caption)
    rows = [list(row) for row in table.iter("tr")]
    headed = table.find("thead") is not None
    native = document.add_table(len(rows), max(map(len, rows)), "Report Table" if headed else "Normal Table")
    text = "Table Text Small" if headed and len(native.columns) > MANY_COLUMNS else "Table Text"
    together = len(rows) if len(rows) <= WHOLE else TOGETHER
    for number, (row, cells) in enumerate(zip(native.rows, rows, strict=True)):
        head = headed and number == 0
        for tag in ("cantSplit", *(("tblHeader",) if head else ())):
            _append(row._tr.get_or_add_trPr(), tag)
        for cell, source in zip(row.cells, cells, strict=True):
            paragraph = _styled(cell.paragraphs[0], "Table Head" if head else text)
            if headed and "text" not in source.classes:
                paragraph.alignment = WD_ALIGN_PARAGRAPH.RIGHT
            if "blank" in source.classes:  # a line to write on
                line = '<w:bottom w:val="single" w:sz="4"/>'
                _append(cell._tc.get_or_add_tcPr(), "tcBorders", inner=line)
            if "tall" in source.classes:
                row.height = STAMP
            if headed and (number < together or number >= len(rows) - together) and number < len(rows) - 1:
                paragraph.paragraph_format.keep_with_next = True
            _words(paragraph, source)
    _paragraph(document, "After Table")


def _paragraph(document: Any, style: str) -> Any:
    return _styled(document.add_paragraph(), style)


def _styled(paragraph: Any, style: str) -> Any:
    """Give a paragraph a style, by its id: the library looks names up among all styles, every time."""
    paragraph._p.style = style.replace(" ", "")
    return paragraph


def _append(parent: Any, tag: str, attributes: str = "", inner: str = "") -> None:
    """Append an element that the library has no method for."""
    parent.append(parse_xml(f"<w:{tag} {nsdecls('w')} {attributes}>{inner}</w:{tag}>"))


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
