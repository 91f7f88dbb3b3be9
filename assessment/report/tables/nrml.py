"""The fragilities as a fragility model of OpenQuake (NRML 0.5)."""

import math
import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from assessment.results.schema import Results

NRML = "http://openquake.org/xmlns/nrml/0.5"
FARTHEST = 5.0  # β above the median: the largest level
WIDEST = 5.0  # β; beyond, mean and deviation soon pass all floats
LONGEST = 60  # characters of an identifier; they are letters and digits of ASCII, and _


def fragility_model(results: Results) -> bytes | None:
    """Return one function for each state of [incremental] and each movement of the campaign; None where there is none.

    Mean and standard deviation are those of the measure (g), median · exp(β²/2) and mean · √(exp β² − 1), as OpenQuake
    takes them. A fragility without β, or with one above WIDEST, is left out.
    """
    document = Element("nrml", xmlns=NRML)
    model = SubElement(
        document, "fragilityModel", id="collapse", assetCategory="buildings", lossCategory="structural"
    )
    SubElement(model, "description").text = results.title
    SubElement(model, "limitStates").text = "collapse"
    for number, (name, measure, median, beta) in enumerate(_fits(results), 1):
        if not median or not beta or beta > WIDEST:
            continue
        own = re.sub(r"\W+", "_", f"{number} {name}", flags=re.ASCII)[:LONGEST]
        function = SubElement(model, "fragilityFunction", id=own, format="continuous", shape="logncdf")
        most, mean = median * math.exp(FARTHEST * beta), median * math.exp(0.5 * beta**2)
        levels = {"noDamageLimit": "0.0", "minIML": "0.0", "maxIML": f"{most:.6g}"}
        SubElement(function, "imls", levels, imt=measure)
        spread = mean * math.sqrt(math.expm1(beta**2))
        SubElement(function, "params", ls="collapse", mean=f"{mean:.6g}", stddev=f"{spread:.6g}")
    if model.find("fragilityFunction") is None:
        return None
    indent(document)
    return tostring(document, encoding="utf-8", xml_declaration=True)


def _fits(results: Results) -> Iterator[tuple[str, str, float | None, float | None]]:
    """Yield name, measure, median (g) and β of every fragility."""
    for name, state in results.states.items():
        if fit := state.incremental.fragility:
            yield name, "PGA", fit.median_g, fit.dispersion
    if campaign := results.campaign:
        measure = "PGA" if campaign.measure == "PGA" else f"SA({campaign.period_s:g})"
        for each in campaign.fragility:
            yield f"{each.settlement} {each.share:g}", measure, each.median_g, each.beta
