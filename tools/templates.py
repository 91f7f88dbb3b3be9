"""The built-in templates as a page of docs/ shows them: a table of their dimensions, and a picture."""

from __future__ import annotations

from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from assessment.project.catalogue.new_project import TEMPLATES, made, template_options
from tools.pictures import write_picture

STONE, SUPPORT = "#d9cdb8", "#8a8a8a"


def dimensions() -> str:
    """Return a table of the templates: what each is, and its dimensions with their defaults."""
    lines = ["| template | is | dimensions |", "|---|---|---|"]
    for name, function in TEMPLATES.items():
        about = (function.__doc__ or "").partition("\n")[0].removeprefix("Return ").rstrip(".")
        given = [
            f"`{key}` = {default:g} ({description})"
            for key, (default, _, description) in template_options(name).items()
        ]
        lines.append(f"| `{name}` | {about} | {', '.join(given)} |")
    return "\n".join([*lines, ""])


def draw(figure: Figure) -> None:
    """Draw every template as it is by default, supports in grey."""
    for axes, name in zip(figure.subplots(4, 3).flat, TEMPLATES, strict=True):
        layout, content = made(name, {})
        for layer, shapes in layout.items():
            fixed = "support" in content["layers"].get(layer, {})
            axes.add_collection(
                PolyCollection(shapes, facecolor=SUPPORT if fixed else STONE, edgecolor="black", lw=0.4)
            )
        axes.autoscale_view()
        axes.set(aspect="equal", title=name)
        axes.set_axis_off()


def write() -> None:
    """Write the picture."""
    write_picture("templates.svg", (9.0, 9.0), draw, 9.0)
