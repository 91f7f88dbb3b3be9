"""How the columns of tables are written: one specification to a name, headed by `column.<name>` of the strings."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from markupsafe import Markup

from assessment.ntc.capacity.return_period import stated
from assessment.ntc.demand.hazard_grid import RETURN_PERIODS
from assessment.ntc.limit_states import ROCK, SURFACE
from assessment.report.text.language import Words, direction_name
from assessment.report.text.messages import translated
from assessment.results.table import Row

COARSE = 2  # digits of numbers that follow from a few records, or are only shown to be small
PER_CENT_DECIMALS = 1  # of a reduction
NONE, OPEN = "none", "not_determined"  # what null means: there is none; there is no capacity to have it of
WHOLE = "*"  # the macro-element of a mechanism in which every layer moves
COUNTED = re.compile(r"(\d+) \+ (\d+)")  # a mechanism by its hinges and sliding joints
GENERATED = re.compile(r"generated (\d+)")  # the name of a record that the program made
Label = TypeVar("Label", str, Markup)


@dataclass(frozen=True)
class Column:
    """How the values of a column are written.

    `factor`: from the unit of results.json to that of the heading; `digits`: significant ones at most; `decimals`:
    of what has an accuracy of its own, in place of digits; `text`: words, set to the left; `null`: what null means, as
    in `value.<null>` of the strings, "none" where there is none; `ground`: what an acceleration refers to, `ROCK` (or
    the surface, where the spectrum is that of a record) or `SURFACE`; `write`: the words for a value that is no plain
    number.
    """

    factor: float = 1.0
    digits: int | None = None
    decimals: int | None = None
    text: bool = False
    null: str = "not_reached"
    ground: str = ""
    write: Callable[[Any, Words], str] | None = None


def check_name(check: str, words: Words) -> str:
    """Write the name of a check: its limit state, and what it is where that has several."""
    if check == "SLV linear":
        return words.plain("value.slv_linear")
    limit, _, kind = check.partition(" ")
    return words.plain("value.elastic_branch", limit=limit) if kind else check


def _governing(value: str, words: Words) -> Markup:
    """Write what set a capacity: a share of d_0, a local limit, activation."""
    parts = [
        Markup(words.name("governing", part, words.comma(part)).replace("d_0", "d<sub>0</sub>"))
        for part in value.split(": ")
    ]
    return Markup(": ").join(parts)


def _return_period(value: float, words: Words) -> str:
    """Write a return period: beyond the hazard as such with its estimate, at its bounds as there or beyond."""
    if beyond := stated(value):
        return f"{beyond} ({words.number(value, COARSE)})"
    sign = "≤ " if RETURN_PERIODS[0] >= value else "≥ " if RETURN_PERIODS[-1] <= value else ""
    return f"{sign}{words.rounded(value, 0)}"


def _mechanism(value: str, words: Words) -> str:
    if not (counted := COUNTED.fullmatch(value)):
        return value
    counts = zip(("hinge", "slide"), counted.groups(), strict=True)
    named = ((what if count == "1" else f"{what}s", count) for what, count in counts if count != "0")
    return ", ".join(words.plain(f"value.{what}", count=count) for what, count in named)


def _record(value: str, words: Words) -> str:
    made = GENERATED.fullmatch(value)
    return words.plain("value.generated", number=made[1]) if made else value


def _stages(value: str, words: Words) -> str:
    return ", ".join(words.name("value", part) for part in value.split(", "))


def _text(write: Callable[[Any, Words], str] | None = None, null: str = NONE) -> Column:
    return Column(text=True, null=null, write=write)


NUMBER, TEXT = Column(), _text()
CALCULATED = Column(null=OPEN)
MILLIMETRES, TENTHS = Column(factor=1000.0), Column(factor=1000.0, decimals=1)
SURVEYED = Column(decimals=3)
TENTHS_OF_PERCENT = Column(factor=100.0, decimals=PER_CENT_DECIMALS, null=OPEN)
PERCENT, COARSE_PERCENT = Column(factor=100.0), Column(factor=100.0, digits=COARSE)
TWO_DIGITS = Column(digits=COARSE)
ON_ROCK, AT_SURFACE = Column(ground=ROCK, null=OPEN), Column(ground=SURFACE)
RETURN_PERIOD = Column(write=_return_period, null=OPEN)
WORD_OF_VALUE = _text(lambda value, words: words.plain(f"value.{value}"))
WORD_OF_SETTING = _text(lambda value, words: words.name("setting", value))

COLUMNS = {
    name: column
    for column, names in (
        (MILLIMETRES, "d_y_m d_0_m d_0_star_m displacement_x_m displacement_z_m movement_m d_0_error_m"),
        (Column(factor=1000.0, null=OPEN), "d_star_m"),
        (CALCULATED, "a_star_g T_s zeta_E ratio zeta_before zeta_SLV zeta_SLC ratio_SLV_linear f_a swing_g"),
        (Column(factor=1000.0, digits=COARSE, null=NONE), "x_error_m z_error_m"),
        (Column(digits=COARSE, null=NONE), "rotation_error_mrad chi_squared_probability"),
        (_text(translated), "hypothesis"),
        (MILLIMETRES, "ultimate_rigid_m ultimate_elastic_m ultimate_movement_m"),
        (TENTHS, "opening_m other_opening_m slip_m"),  # of a millimetre: what a survey measures
        (SURVEYED, "x_m z_m from_x_m from_z_m to_x_m to_z_m"),
        (MILLIMETRES, "peak_displacement_m residual_displacement_m lowest_peak_m median_peak_m highest_peak_m"),
        (MILLIMETRES, "peak_displacement_error_m peak_displacement_scatter_m"),
        (TENTHS_OF_PERCENT, "IS_V PAM gain reduction static_reduction dynamic_reduction"),
        (PERCENT, "relative_error relative_scatter integrator_share"),
        (COARSE_PERCENT, "dynamic_loss dynamic_loss_low dynamic_loss_high static_loss deviation hand_deviation"),
        (Column(digits=COARSE, null=NONE), "beta_low beta_high"),  # fewer than three records have no interval
        (Column(null=NONE, ground=SURFACE), "median_low_g median_high_g"),
        (TWO_DIGITS, "beta beta_record beta_ensemble I_S acceptable_nominal_life_years"),
        (ON_ROCK, "a_g_g demand_a_g_g a_g_error_g a_g_low_g a_g_base_g a_g_high_g"),
        (Column(ground=SURFACE, null=OPEN), "pga_g demand_pga_g static_pga_g static_surface_pga_g"),
        (AT_SURFACE, "dynamic_pga_g record_pga_g pga_safe_g median_g"),
        (AT_SURFACE, "pga_collapse_g pga_all_collapse_g mean_pga_collapse_g lowest_pga_collapse_g"),
        (AT_SURFACE, "pga_collapse_error_g median_all_collapse_g"),
        (Column(null=NONE), "rest_kN peak_kN greatest_kN time_of_greatest_s yield_force_kN stiffness_kN_m"),
        (RETURN_PERIOD, "return_period_years T_SLV_years"),
        (Column(null=NONE), "x_C_m z_C_m"),  # a block that does not turn has no centre
        (Column(write=lambda value, words: words.comma(f"{100.0 * value:g}")), "share"),
        (Column(text=True, null=NONE, ground=SURFACE), "resurrections"),
        (TEXT, "layer support quantity use_class IS_V_class PAM_class origin counts soil topography"),
        (TEXT, "refused collapses collapsed table setting value expected computed case source control settlement tie"),
        (TEXT, "measurement unit told_apart"),
        (_text(lambda value, words: "; ".join(map(words.state, value.split("; ")))), "states"),
        (_text(lambda value, words: words.state(value)), "state"),
        (_text(lambda value, words: direction_name(value)), "direction"),
        (_text(check_name), "limit_state"),
        (_text(lambda value, words: words(f"value.parameter_{value}")), "parameter"),
        (_text(_governing), "governing"),
        (_text(_mechanism), "mechanism"),
        (_text(_record), "record"),
        (_text(_stages), "stage"),
        (_text(lambda value, words: words.plain(f"value.{'verified' if value else 'not_verified'}"), OPEN), "verified"),
        (_text(null=OPEN), "risk_class"),
        (_text(lambda value, words: words.plain(f"value.{value}_spectrum")), "kind"),
        (_text(lambda value, words: words.plain(f"value.scaling_{value.replace('-', '_')}")), "scaling"),
        (_text(lambda value, words: words.plain("value.whole_structure") if value == WHOLE else value),
         "macro_element"),
        (WORD_OF_VALUE, "contacts property rule measured_kind"),
        (WORD_OF_SETTING, "use_category integrator"),
    )
    for name in names.split()
}  # fmt: skip
"""Of every column that is more than a number with the unit of results.json."""


def is_text(name: str) -> bool:
    """Return whether a column has words, set to the left."""
    return COLUMNS.get(name, NUMBER).text


def heading(name: str, words: Words, reference: str) -> Markup:
    """Write the heading of a column; that of an acceleration names what it refers to.

    `reference`: of the a_g of the checks, `ROCK` or `SURFACE`.
    """
    text, ground = words(f"column.{name}"), COLUMNS.get(name, NUMBER).ground
    return referenced(text, words, reference if ground == ROCK else ground) if ground else text


def referenced(label: Label, words: Words, reference: str) -> Label:
    """Put into a label with the unit [g] whether the acceleration is on rock or at the surface."""
    return label.replace(" [g]", f" {words.plain(f'value.on_{reference}')} [g]")


def cell(name: str, row: Row, words: Words, significant: int = 3) -> Markup:
    """Write the value of a column in a row: a dash where it was not requested."""
    return written(name, row[name], words, significant) if name in row else words("value.none")


def written(name: str, value: Any, words: Words, significant: int = 3) -> Markup:
    """Write one value of a column in the unit of its heading: "not reached" for null, HTML as it is."""
    column = COLUMNS.get(name, NUMBER)
    if isinstance(value, Markup):
        return value
    if value is None:
        return words(f"value.{column.null}")
    if column.write:
        return Markup.escape(column.write(value, words))
    if value == "inf" and not column.text:  # an input: results have no infinity
        return Markup("∞")
    if isinstance(value, float):
        if column.decimals is not None:
            return Markup.escape(words.rounded(column.factor * value, column.decimals))
        digits = min(significant, column.digits or significant)
        return Markup.escape(words.number(column.factor * value, digits))
    return Markup.escape(words.show(value))
