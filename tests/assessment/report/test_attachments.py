"""Photographs and survey drawings: checked before any analysis, printed in all three forms of the report."""

import pytest
from docx import Document
from PIL import EpsImagePlugin, Image, ImageFile

from assessment.cli.main import main
from assessment.project.project import load_project
from assessment.report.document import LONGEST, write_attachments
from assessment.runtime.errors import ProjectError
from tests.support.block_project import PROJECT, edit, write_block

ATTACHED = '[report]\nlanguage = "it"\nattachments = ["South_front.jpg", "survey.png"]\n'
ORIENTATION = 0x0112  # EXIF; 6: the camera was turned by a right angle


def photograph(path, size=(400, 200), orientation=6):
    picture = Image.new("RGB", size, "grey")
    exif = picture.getexif()
    exif[ORIENTATION] = orientation
    exif[0x010F] = "Maker"
    picture.save(path, exif=exif)


@pytest.fixture
def project(tmp_path):
    folder = write_block(tmp_path / "block", PROJECT + ATTACHED)
    photograph(folder / "South_front.jpg")
    Image.new("L", (50, 80), 255).save(folder / "survey.png")
    return folder


def refused(project):
    with pytest.raises(ProjectError) as error:
        load_project(project)
    return str(error.value)


@pytest.mark.parametrize("program", [b"{} loop", b"(x) run"])
def test_attachment_eps_in_png(program, tmp_path, monkeypatch):
    """Each of these names of PostScript, TIFF, BMP or GIF content is refused before a plugin of Pillow sees it."""
    monkeypatch.setattr(EpsImagePlugin, "Ghostscript", lambda *_: pytest.fail("Ghostscript was run"))
    postscript = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n"
    (tmp_path / "photo.png").write_bytes(postscript + program)
    pictures = [tmp_path / "photo.png"]
    for kind in ("tiff", "bmp", "gif"):
        pictures.append(tmp_path / f"{kind}.jpg")
        Image.new("L", (9, 9)).save(pictures[-1], kind)
    for path in pictures:
        with pytest.raises(ValueError, match="neither PNG nor JPEG"):
            write_attachments([path], tmp_path)


def test_pictures_are_upright_small_and_without_hidden_data(tmp_path):
    photograph(tmp_path / "a.JPG", (3 * LONGEST, LONGEST))
    write_attachments([tmp_path / "a.JPG"], tmp_path)
    with Image.open(tmp_path / "attachments" / "01.jpg") as made:
        assert made.size == (LONGEST // 3, LONGEST)
        assert not made.getexif()


@pytest.mark.parametrize("accepted", [False, True], ids=["by default", "after WeasyPrint is imported"])
def test_what_is_no_picture_is_refused_with_one_message(project, monkeypatch, accepted):
    monkeypatch.setattr(ImageFile, "LOAD_TRUNCATED_IMAGES", accepted)
    (project / "survey.png").write_bytes((project / "survey.png").read_bytes()[:60])
    message = refused(project)
    assert (
        message.startswith("project.toml: report.attachments[2]: ")
        and "cannot be read as a picture" in message
    )
    (project / "survey.png").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EOF\n{} loop\n")
    assert "its content is neither PNG nor JPEG" in refused(project)
    (project / "survey.pdf").write_bytes(b"%PDF-1.7")
    edit(project, "survey.png", "survey.pdf")
    assert "a PDF page by page" in refused(project) and "\n" not in refused(project)
    edit(project, "survey.pdf", "gone.png")
    assert "gone.png" in refused(project)


@pytest.mark.usefixtures("quick")
def test_the_report_ends_with_them_and_another_picture_is_printed(project, monkeypatch):
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    monkeypatch.setattr("assessment.workflow.run.processes", lambda _: 1)  # one that is spawned has pictures
    output = project / "output"
    assert main(["run", str(project), "--jobs", "1"]) == 0
    page = (output / "report.html").read_text(encoding="utf-8")
    assert page.index("South front") < page.index("survey</figcaption>")
    assert "Documentazione fotografica e di rilievo" in page and "data:image/jpeg;base64," in page
    shapes = Document(output / "report.docx").inline_shapes
    assert [shape._inline.docPr.get("descr") for shape in shapes][-2:] == ["South front", "survey"]
    before = (output / "results.json").stat().st_mtime_ns, (output / "report.html").stat().st_mtime_ns
    assert main(["run", str(project), "--jobs", "1"]) == 0
    assert (output / "report.html").stat().st_mtime_ns == before[1], "nothing changed"
    photograph(project / "South_front.jpg", orientation=1)
    assert main(["run", str(project), "--jobs", "1"]) == 0
    with Image.open(output / "attachments" / "01.jpg") as made:
        assert made.size == (400, 200)
    edit(project, '"South_front.jpg", "survey.png"', '"survey.png"')
    assert main(["report", str(project)]) == 0
    assert [path.name for path in (output / "attachments").iterdir()] == ["01.png"]
