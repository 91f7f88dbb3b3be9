"""The masonry of a template as the mechanics know it, without files between them."""

from typing import Any

from assessment.project.catalogue.new_project import made
from mechanics import Assembly, Block, Material
from mechanics.model.block import Tie


def template_assembly(template: str, tolerance: float | None = None, **options: Any) -> Assembly:
    """Return the blocks of a template with its own stone, depths and loads, as drawn, without ties."""
    layout, content = made(template, options)
    common = content["material"]
    blocks = []
    for layer, shapes in layout.items():
        own = content["layers"].get(layer, {})
        stone = Material(
            own.get("unit_weight_kN_m3", common["unit_weight_kN_m3"]), own.get("friction", common["friction"])
        )
        blocks += [
            Block(
                each, own.get("depth_m", content["geometry"]["depth_m"]), stone, support=own.get("support"),
                vertical_load=own.get("vertical_load_kN", 0.0), layer=layer,
            )
            for each in shapes
        ]  # fmt: skip
    return Assembly(blocks, tolerance=tolerance)


def with_ties(template: str, model: Assembly, **options: Any) -> Assembly:
    """Return the blocks with the ties of a template."""
    _, content = made(template, options)
    return model.tied(
        [Tie(each["name"], each["from_m"], each["to_m"], each["yield_force_kN"]) for each in content["tie"]]
    )
