"""Columns of tables that follow from the results: what a report works out and results.json does not have."""

from __future__ import annotations

from typing import Any

from assessment.results.schema.part import Label, Part, key


def column(unit: str, label: Label, **look: Any) -> Any:
    """Describe a column; see Quantity."""
    return key("", unit, label, **look)


class Derived(Part):
    """Every such column, by its name in tables/*.csv."""

    chi_squared_probability: float = column("–", ("Probabilità", "Probability"), digits=2, null="none")
    told_apart: str = column("", ("Distinta dalla migliore", "Told from the best"))
    x_error_m: float = column("m", "±", shown="mm", digits=2, null="none")
    z_error_m: float = column("m", "±", shown="mm", digits=2, null="none")
    rotation_mrad: float = column("mrad", ("Rotazione", "Rotation"))
    rotation_error_mrad: float = column("mrad", "±", digits=2, null="none")
    number: float = column("", ("N.", "No."))
    measured_kind: str = column("", ("Tipo", "Kind"))
    from_x_m: float = column("m", "x_1", decimals=3)
    from_z_m: float = column("m", "z_1", decimals=3)
    to_x_m: float = column("m", "x_2", decimals=3)
    to_z_m: float = column("m", "z_2", decimals=3)
    time_of_greatest_s: float = column("s", ("Istante", "Time"), null="none")
    before: str = column("", ("Prima", "Before"))
    after: str = column("", ("Dopo", "After"))
    alpha_own_run: float = column("–", ("α_0, analisi propria", "α_0, own run"))
    alpha_0_associative: float = column("–", ("α_0 con attrito associato", "α_0, associative friction"))
    alpha_0_coulomb: float = column("–", ("α_0 con attrito di Coulomb", "α_0, Coulomb friction"))
    macro_element: str = column("", ("Macroelemento", "Macro-element"))
    ratio_SLV_linear: float = column(
        "–", ("Rapporto SLV lineare", "Ratio SLV linear"), null="not_determined", ratio=True
    )
    mark: str = column("", ("Segno", "Mark"))
    measured_mm: float = column("mm", ("Misurato", "Measured"), decimals=1, null="none")
    sigma_mm: float = column("mm", "σ", decimals=1, null="none")
    calculated_mm: float = column("mm", ("Calcolato", "Calculated"), decimals=1, null="none")
    P_VR: float = column("–", "P_VR", shown="%")
    share_used: float = column(
        "–", ("Quota del tiro di snervamento", "Share of the yield force"), shown="%", digits=2
    )
    plate_20_MPa: float = column("MPa", ("Piastra 20 × 20 cm", "Plate 20 × 20 cm"), digits=2)
    plate_30_MPa: float = column("MPa", ("Piastra 30 × 30 cm", "Plate 30 × 30 cm"), digits=2)
    plate_40_MPa: float = column("MPa", ("Piastra 40 × 40 cm", "Plate 40 × 40 cm"), digits=2)
    opening_m: float = column("m", ("Apertura", "Opening"), shown="mm", decimals=1)
    other_opening_m: float = column("m", ("All’altro estremo", "At the other end"), shown="mm", decimals=1)
    slip_m: float = column("m", ("Scorrimento", "Slip"), shown="mm", decimals=1)
    improvement: float = column("–", ("Miglioramento, §8.4.2", "Improvement, §8.4.2"))
    improvement_school: float = column("–", ("Scuole, §8.4.2", "Schools, §8.4.2"))
    retrofit_use: float = column("–", ("Adeguamento c, e, §8.4.3", "Retrofit c, e, §8.4.3"))
    retrofit: float = column("–", ("Adeguamento a, b, d, §8.4.3", "Retrofit a, b, d, §8.4.3"))
    parameter: str = column("", ("Parametro", "Parameter"))
    factor_component: float = column("–", "F_Ck")
    origin: str = column("", ("Origine", "Origin"))
    scaling: str = column("", ("Domanda seguita per", "Demand followed by"))
    counts: str = column("", ("Adottata", "Adopted"))
    alpha_0_given: float = column("–", ("α_0 lavori virtuali", "α_0 virtual work"))
    area_m2: float = column("m²", "Area")
    unit_weight_kN_m3: float = column("kN/m³", ("Peso sp.", "Unit weight"))
    normal_stiffness_kN_m3: float = column("kN/m³", "k_n")
    tangential_stiffness_kN_m3: float = column("kN/m³", "k_t")
    block_a: float = column("", ("Blocco a", "Block a"))
    block_b: float = column("", ("Blocco b", "Block b"))
    edge_pressure_kN_m2: float = column("kN/m²", ("Pressione al bordo", "Edge pressure"), shown="MPa")
    uncrushed_pressure_kN_m2: float = column(
        "kN/m²", ("Senza schiacciamento", "Without crushing"), shown="MPa"
    )
    displacement_x_m: float = column("m", "δ_x", shown="mm")
    displacement_z_m: float = column("m", "δ_z", shown="mm")
    ultimate_rigid_m: float = column("m", ("Ultimo, rigido", "Ultimate, rigid"), shown="mm")
    ultimate_elastic_m: float = column("m", ("Ultimo, elastico", "Ultimate, elastic"), shown="mm")
    lowest: float = column("", ("Minimo", "Lowest"))
    highest: float = column("", ("Massimo", "Highest"))
    lowest_peak_m: float = column("m", ("Picco minimo", "Lowest peak"), shown="mm")
    median_peak_m: float = column("m", ("Mediano", "Median"), shown="mm")
    highest_peak_m: float = column("m", ("Massimo", "Highest"), shown="mm")
    pga_all_collapse_g: float = column("g", ("PGA a cui tutti collassano", "All collapse"), ground="surface")
    widest_gap: str = column("g", ("Intervallo più largo", "Widest gap"), ground="surface")
    resurrections: str = column("g", ("PGA sopportate oltre", "Withstood above"), ground="surface")
    median_low_g: float = column(
        "g", ("Estremo inferiore, 95 %", "Lower end, 95 %"), null="none", ground="surface"
    )
    median_high_g: float = column(
        "g", ("Estremo superiore, 95 %", "Upper end, 95 %"), null="none", ground="surface"
    )
    beta_low: float = column("–", ("da", "from"), digits=2, null="none")
    beta_high: float = column("–", ("a", "to"), digits=2, null="none")
    dynamic_loss_low: float = column("–", ("Limite inf., 95 %", "Lower, 95 %"), shown="%", digits=2)
    dynamic_loss_high: float = column("–", ("Limite sup., 95 %", "Upper, 95 %"), shown="%", digits=2)
    median_of_measure: float = column("", ("Mediana", "Median"))
    beta_of_measure: float = column("–", "β", digits=2)
    efficient: str = column("", ("La più efficiente", "Most efficient"))
    analysis: str = column("", ("Analisi", "Analysis"))
    pga_surface_g: float = column("g", "PGA", null="not_determined", ground="surface")
    over_static: float = column("–", ("Su quella statica", "Over the static one"), null="none", ratio=True)
    capacity_loss: float = column("–", ("Perdita", "Loss"), shown="%", digits=2, null="none")
    static_loss: float = column("–", ("Perdita statica", "Static loss"), shown="%", digits=2)
    macro_block: float = column("", ("N.", "No."))
    x_G_m: float = column("m", "x_G")
    z_G_m: float = column("m", "z_G")
    omega: float = column("rad", "ω")
    x_C_m: float = column("m", "x_C", null="none")
    z_C_m: float = column("m", "z_C", null="none")
    delta_x: float = column("m", "δ_x")
    delta_z: float = column("m", "δ_z")
    work_load: float = column("kNm", "W_s δ_x")
    work_weight: float = column("kNm", "W δ_z")
    alpha_mechanism: float = column("–", ("α programma", "α program"))
    hand_alpha: float = column("–", ("α macroblocchi", "α macro-blocks"))
    hand_deviation: float = column(
        "–", ("Scarto, macroblocchi", "Deviation, macro-blocks"), shown="%", digits=2
    )
    deviation: float = column("–", ("Scarto", "Deviation"), shown="%", digits=2)
    mechanism_alpha: float = column("–", ("α dove si attiva", "α where it is activated"))
    case: str = column("", ("Caso", "Case"))
    source: str = column("", ("Fonte", "Source"))
    load_x_kN: float = column("kN", ("Carico x", "Load x"))
    load_z_kN: float = column("kN", ("Carico z", "Load z"))
    unbalanced: float = column("–", ("Squilibrio / peso", "Unbalanced / weight"))
    expected: str = column("", ("Valore di riferimento", "Reference value"))
    table: str = column("", ("Gruppo", "Group"))
    setting: str = column("", ("Grandezza", "Quantity"))
    value: str = column("", ("Valore", "Value"))
    low_factor: float = column("", ("Fattore basso", "Low factor"))
    high_factor: float = column("", ("Fattore alto", "High factor"))
    a_g_low_g: float = column(
        "g", ("a_g (fattore basso)", "a_g (low factor)"), null="not_determined", ground="rock"
    )
    a_g_base_g: float = column(
        "g", ("a_g (valore assegnato)", "a_g (as given)"), null="not_determined", ground="rock"
    )
    a_g_high_g: float = column(
        "g", ("a_g (fattore alto)", "a_g (high factor)"), null="not_determined", ground="rock"
    )
    swing_g: float = column("g", ("Escursione", "Swing"), null="not_determined")
    reduction_strengthened: float = column(
        "–", ("Riduzione, intervento compreso", "Reduction, strengthening included"), shown="%", change=True
    )
