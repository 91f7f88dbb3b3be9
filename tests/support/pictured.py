"""Figures for tests that read the page: real ones of the chapters that they look at, empty ones of the others."""

from pathlib import Path

from assessment.report.document import render_html
from assessment.report.figures.drawing import save_svg
from assessment.report.figures.index import pictures
from assessment.report.language import LANGUAGES, Words
from assessment.results.schema import Results

EMPTY = '<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9"/>'


def draw_sections(results: Results, folder: Path, *sections: str) -> None:
    """Write every figure of the results into the folder, those of other sections without content."""
    for picture in pictures(results):
        path = folder / f"{picture.name}.svg"
        if picture.section in sections:
            save_svg(picture.draw, path)
        else:
            path.write_text(EMPTY, encoding="utf-8")


def pages_of(results: Results, folder: Path) -> dict[str, str]:
    """Return the page in each language, its blanks single ones, without pictures."""
    draw_sections(results, folder)
    made = {language: render_html(results, folder, Words.of(language)) for language in LANGUAGES}
    return {language: " ".join(page.split()) for language, page in made.items()}
