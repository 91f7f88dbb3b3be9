"""The vertical loads of each layer in the seismic combination, and the text on the vertical component."""

from __future__ import annotations

from collections.abc import Sequence

from assessment.report.tables.capacity import capacities
from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.model import LayerLoads
from assessment.results.schema.part import present
from assessment.results.table import Table, cells

LOADS = (
    "layer",
    "blocks",
    "own_weight_kN",
    "permanent_load_kN",
    "variable_load_kN",
    "use_category",
    "psi_2",
    "combined_kN",
    "seismic_weight_kN",
)
VARIABLE = {"variable_load_kN", "use_category", "psi_2"}
VERTICAL = (
    "state",
    "direction",
    "a_v_g",
    "alpha_0",
    "a_0_star_g",
    "demand_a_star_g",
    "ratio",
    "verified",
)


def loads(results: Results) -> Table:
    """List own weight, permanent and variable loads of each layer, ψ₂, and their combination; all blocks together."""
    return Table("loads", [cells(each, LOADS) for each in results.loads or []], LOADS)


def reported_loads(results: Results, words: Words) -> Table:
    """Return the loads with their sums, without what no layer has."""
    layers = results.loads or []
    varies = any(layer.variable_load_kN for layer in layers)
    columns = tuple(column for column in LOADS if varies or column not in VARIABLE)
    summed = [*layers, _sum(layers, words.plain("value.sum"))] if len(layers) > 1 else layers
    return Table("loads", [present(cells(each, columns)) for each in summed], columns)


def _sum(layers: Sequence[LayerLoads], name: str) -> LayerLoads:
    """Return the loads of all layers together."""
    return LayerLoads(
        layer=name,
        blocks=sum(layer.blocks for layer in layers),
        own_weight_kN=sum(layer.own_weight_kN for layer in layers),
        permanent_load_kN=sum(layer.permanent_load_kN for layer in layers),
        variable_load_kN=sum(layer.variable_load_kN for layer in layers),
        use_category=None,
        psi_2=None,
        combined_kN=sum(layer.combined_kN for layer in layers),
        seismic_weight_kN=sum(layer.seismic_weight_kN for layer in layers),
    )


def vertical(results: Results) -> Table:
    """List the linear checks at SLV with the vertical component of the seismic action."""
    rows = [
        {"state": name, "direction": direction} | cells(capacity.vertical, VERTICAL)
        for name, direction, capacity in capacities(results)
        if capacity.vertical
    ]
    return Table("vertical", rows, VERTICAL)
