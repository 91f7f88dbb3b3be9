"""What every table of results is made of, and the columns that are in no class of rows."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, get_type_hints

from assessment.ntc.tables import INDEXED, ROCK, SURFACE, farthest
from assessment.results.schema import Capacities, Results, Scenarios, SummaryRow
from assessment.results.schema.checks import Capacity, Check, ComparisonRow
from assessment.results.schema.part import QUANTITIES, Part, enter, key, plain_value

ORIGINAL = "original"
Row = dict[str, Any]


@dataclass(frozen=True)
class Table:
    """Rows as dictionaries. A missing key was not requested; None was requested and not reached."""

    name: str
    rows: list[Row]
    columns: tuple[str, ...]


def sense(direction: str) -> float:
    """Return +1 for a push towards +x, −1 towards −x: displacements along the push times it are those along x."""
    return -1.0 if direction == "-x" else 1.0


def reduction(original: float | None, settled: float | None) -> float | None:
    """Return 1 − settled/original: positive where the movement costs capacity; None where one is not known."""
    return None if not original or settled is None else 1.0 - settled / original


@cache
def columns_of(row: type) -> tuple[str, ...]:
    """Return the columns of a table whose rows are of a class: its fields, of a part those with a label; no lists.

    The quantities that a dataclass describes are entered.
    """
    if issubclass(row, Part):
        described = row.model_fields.items()
        return tuple(name for name, each in described if name in QUANTITIES and plain_value(each.annotation))
    hints = get_type_hints(row, include_extras=True)
    for name, hint in hints.items():
        for told in getattr(hint, "__metadata__", ()):
            enter(name, hint.__origin__, dict(told))
    return tuple(name for name, hint in hints.items() if plain_value(hint))


def cells(part: Part, columns: Iterable[str]) -> Row:
    """Return the columns that a part has: here alone is a missing key another thing than null."""
    return {column: getattr(part, column) for column in columns if column in part.model_fields_set}


def quoted_check(capacity: Capacity | None) -> Check | None:
    """Return the check of the farthest limit state that was checked in a direction."""
    checks = capacity.checks if capacity else {}
    return checks[limit] if (limit := farthest(checks)) else None


def static_pga(capacity: Capacity | None) -> float | None:
    """Return the PGA borne at the surface (g), S a_g, at the farthest limit state that was checked in a direction."""
    check = quoted_check(capacity)
    return check.pga_g if check else None


def compared(found: Capacities, quantity: str) -> float | None:
    """Return the quantity that capacities are compared by: a_g (g), α_0 or α_u."""
    return getattr(found, quantity)


def weaker(capacities: Iterable[float | None]) -> float | None:
    """Return the least of the capacities in each direction; None where one is not known, or there is none."""
    values = list(capacities)
    known = [value for value in values if value is not None]
    return min(known) if known and len(known) == len(values) else None


def among_known(found: Scenarios) -> tuple[int, int] | None:
    """Return how many of the settled points have the quantity that is compared, and of how many; None where all do."""
    settled = [point for point in found.points if point.state != "original"]
    known = sum(compared(point, found.quantity) is not None for point in settled)
    return (known, len(settled)) if known < len(settled) else None


def reference_of(results: Results) -> str:
    """Return where the a_g of the checks is: on "rock", or at the "surface" where the spectrum is a record's."""
    kinds = {spectrum.kind for spectrum in (results.spectra or {}).values()}
    return SURFACE if kinds == {"record"} else ROCK


def indices(ratios: Mapping[str, float]) -> dict[str, float]:
    """Return those of the ratios of a direction, by check, that are an index ζ_E (NTC 2018, §8.3): at SLV and SLC.

    The linear check at SLV is an alternative to the nonlinear one, and replaces it where that one has no number.
    """
    found = {name: ratio for name, ratio in ratios.items() if name.partition(" ")[0] in INDEXED}
    if "SLV" in found:
        found.pop("SLV linear", None)
    return found


class Derived(Part):
    """Every such column, by its name in tables/*.csv."""

    chi_squared_probability: float = key("", "Probabilità|Probability", digits=2, null="none")
    told_apart: str = key("", "Distinta dalla migliore|Told from the best")
    x_error_m: float = key("", "±", shown="mm", digits=2, null="none")
    z_error_m: float = key("", "±", shown="mm", digits=2, null="none")
    rotation_mrad: float = key("", "Rotazione|Rotation")
    rotation_error_mrad: float = key("", "±", digits=2, null="none")
    number: int = key("", "N.|No.")
    from_x_m: float = key("", "x_1", decimals=3)
    from_z_m: float = key("", "z_1", decimals=3)
    to_x_m: float = key("", "x_2", decimals=3)
    to_z_m: float = key("", "z_2", decimals=3)
    time_of_greatest_s: float = key("", "Istante|Time", null="none")
    alpha_own_run: float = key("", "α_0, analisi propria|α_0, own run")
    alpha_0_associative: float = key("", "α_0 con attrito associato|α_0, associative friction")
    alpha_0_coulomb: float = key("", "α_0 con attrito di Coulomb|α_0, Coulomb friction")
    macro_element: str = key("", "Macroelemento|Macro-element")
    ratio_SLV_linear: float = key("", "Rapporto SLV lineare|Ratio SLV linear", ratio=True)
    P_VR: float = key("", "P_VR", shown="%", decimals=0)
    share_used: float = key("", "Quota del tiro di snervamento|Share of the yield force", shown="%", digits=2)
    plate_20_MPa: float = key("", "Piastra 20 × 20 cm|Plate 20 × 20 cm", digits=2)
    plate_30_MPa: float = key("", "Piastra 30 × 30 cm|Plate 30 × 30 cm", digits=2)
    plate_40_MPa: float = key("", "Piastra 40 × 40 cm|Plate 40 × 40 cm", digits=2)
    intervention: str = key("", "Intervento|Intervention")
    parameter: str = key("", "Parametro|Parameter")
    factor_component: float = key("", "F_Ck")
    origin: str = key("", "Origine|Origin")
    alpha_0_given: float = key("", "α_0 lavori virtuali|α_0 virtual work")
    area_m2: float = key("", "Area")
    unit_weight_kN_m3: float = key("", "Peso sp.|Unit weight")
    normal_stiffness_kN_m3: float = key("", "k_n")
    tangential_stiffness_kN_m3: float = key("", "k_t")
    displacement_x_m: float = key("", "δ_x", shown="mm")
    displacement_z_m: float = key("", "δ_z", shown="mm")
    ultimate_rigid_m: float = key("", "Ultimo, rigido|Ultimate, rigid", shown="mm")
    ultimate_elastic_m: float = key("", "Ultimo, elastico|Ultimate, elastic", shown="mm")
    used: str = key("", "Valore adottato|Used")
    lowest: float = key("", "Minimo|Lowest", unit="")
    highest: float = key("", "Massimo|Highest", unit="")
    lowest_peak_m: float = key("", "Picco minimo|Lowest peak", shown="mm")
    median_peak_m: float = key("", "Mediano|Median", shown="mm")
    highest_peak_m: float = key("", "Massimo|Highest", shown="mm")
    pga_all_collapse_g: float = key("", "PGA a cui tutti collassano|All collapse", ground="surface")
    widest_gap: str = key("", "Intervallo più largo|Widest gap", unit="g", ground="surface")
    resurrections: str = key("", "PGA sopportate oltre|Withstood above", unit="g", ground="surface")
    median_low_g: float = key("", "Estremo inferiore, 95 %|Lower end, 95 %", null="none", ground="surface")
    median_high_g: float = key("", "Estremo superiore, 95 %|Upper end, 95 %", null="none", ground="surface")
    beta_low: float = key("", "da|from", digits=2, null="none")
    beta_high: float = key("", "a|to", digits=2, null="none")
    dynamic_loss_low: float = key("", "Limite inf.|Lower bound", change=True)
    dynamic_loss_high: float = key("", "Limite sup.|Upper bound", change=True)
    median_of_measure: float = key("", "Mediana|Median", unit="")
    beta_of_measure: float = key("", "β", digits=2)
    efficient: str = key("", "La più efficiente|Most efficient")
    analysis: str = key("", "Analisi|Analysis")
    pga_surface_g: float = key("", "PGA", null="not_determined", ground="surface")
    over_static: float = key("", "Sulla statica minima|Over the least static one", null="none", ratio=True)
    capacity_loss: float = key("", "Perdita|Loss", change=True, null="none")
    static_loss: float = key("", "Perdita statica|Static loss", change=True)
    work_load: float = key("", "W_s δ_x", unit="kNm")
    work_weight: float = key("", "W δ_z", unit="kNm")
    mechanism_alpha: float = key("", "α dove si attiva|α where it is activated")
    case: str = key("", "Caso|Case")
    source: str = key("", "Fonte|Source")
    load_x_kN: float = key("", "Carico x|Load x")
    load_z_kN: float = key("", "Carico z|Load z")
    unbalanced: float = key("", "Squilibrio / peso|Unbalanced / weight", digits=2)
    expected: str = key("", "Valore di riferimento|Reference value")
    table: str = key("", "Gruppo|Group")
    setting: str = key("", "Grandezza|Quantity")
    value: str = key("", "Valore|Value")


def comparison(rows: Sequence[SummaryRow]) -> list[ComparisonRow]:
    """Return a row for each settled state and direction beside that of the original state, from those of the summary.

    The static capacity has F_C; the dynamic one has none, and is compared with the static one without it.
    """
    drawn = {row.direction: row for row in rows if row.state == ORIGINAL}
    pairs = [(drawn[row.direction], row) for row in rows if row.state != ORIGINAL and row.direction in drawn]
    return [
        ComparisonRow(
            state=now.state, direction=now.direction, limit_state=was.limit_state or now.limit_state,
            static_pga_g=now.static_pga_g, static_reduction=reduction(was.static_pga_g, now.static_pga_g),
            dynamic_pga_g=now.dynamic_pga_g, dynamic_reduction=reduction(was.dynamic_pga_g, now.dynamic_pga_g),
        )
        for was, now in pairs
    ]  # fmt: skip
