"""Variable loads in the seismic combination: ψ₂ of NTC 2018, Tab. 2.5.I, not compared with the text [k].

G_1 + G_2 + P + E + Σ ψ₂ Q ([2.5.5]); the seismic masses are those of G_1 + G_2 + Σ ψ₂ Q ([3.2.4]).
"""

from __future__ import annotations

PSI_2 = {
    "A": 0.3,
    "B": 0.3,
    "C": 0.6,
    "D": 0.6,
    "E": 0.8,
    "F": 0.6,
    "G": 0.3,
    "H": 0.0,
    "wind": 0.0,
    "snow": 0.0,
    "snow above 1000 m": 0.2,
}
OWN_PSI_2 = ("I", "K")  # of these categories the designer decides case by case


def psi_2(category: str | None, given: float | None) -> float:
    """Return ψ₂ of a variable load: as given, else that of its category of use (Tab. 2.5.I); 0 without either.

    Raises KeyError for a category that is not in the table, or that has no value there.
    """
    if given is not None:
        return given
    return PSI_2[category] if category is not None else 0.0
