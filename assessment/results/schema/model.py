"""The model as read: its size, its blocks and joints, and what the run was made with."""

from typing import Any

from assessment.results.schema.part import Part, Point, Sentence, key, optional


class DrawnTie(Part):
    """`model.ties[]`: a tie rod as drawn."""

    name: str = key("name in the project file")
    start_m: Point = key("one end: x, z")
    end_m: Point = key("the other end: x, z")
    blocks: list[int] = key("numbers of the blocks that hold its ends")
    yield_force_kN: float | None = key(
        "tension at which it lengthens at no more; null: none", "Tiro di snervamento|Yield force", null="none"
    )
    stiffness_kN_m: float | None = key("of the whole tie; null: rigid", "Rigidezza|Stiffness", null="none")
    pretension_kN: float = key("tension when it is set", "Pretensione|Pretension")
    ultimate_elongation: float | None = key(
        "share of its length by which it yields before it breaks; null: it does not break",
        "Allungamento ultimo|Ultimate elongation", shown="%", null="none",
    )  # fmt: skip
    states: list[str] = key("states in which it is there", "Stati|States")
    set_in: list[str] = key("of these, strengthened ones in which it is set after the movement")


class ModelSummary(Part):
    """`model`: what was read from the drawing."""

    blocks: int = key("blocks, those of supports included")
    movable_blocks: int = key("blocks that are no support")
    joints: int = key("joints found in the drawing")
    unknowns: int = key("internal forces: three a joint")
    contact_points: int = key("contact points of the paper; analysed with `segments_per_joint` only")
    weight_kN: float = key("weight of the movable blocks with their vertical loads")
    self_weight_stable: bool = key("whether the structure stands as drawn; false: nothing else was computed")
    warnings: list[Sentence] = key("what is odd in the drawing")
    ties: list[DrawnTie] | None = optional("tie rods; missing: none")


class DrawnBlock(Part):
    """`geometry.blocks[]`: a block as drawn; the number of a block is its place in this list, from 0."""

    vertices_m: list[Point] = key("corners, anticlockwise: x, z")
    centroid_m: Point = key("centroid as drawn: x, z")
    depth_m: float = key("depth out of plane", "Spessore|Depth")
    layer: str = key("layer of the drawing", "Layer")
    handle: str = key("handle of its polyline in the drawing")
    region: str | None = optional("region of the project that it lies in; null: none")
    support: str | None = key("name of the support that it belongs to; null: it moves")
    vertical_load_kN: float = key("at its centroid, down: G_2 + ψ₂ Q", "Carico G_2 + ψ_2 Q|Load G_2 + ψ_2 Q")
    weight_kN: float = key("own weight with the vertical load", "W")


class LayerLoads(Part):
    """`loads[]`: vertical loads of the blocks of a layer, G_1 + G_2 + ψ₂ Q (NTC 2018, §2.5.3)."""

    layer: str = key("layer of the drawing")
    blocks: int = key("its blocks", "Blocchi|Blocks")
    own_weight_kN: float = key("G_1, of the stone", "Peso proprio G_1|Own weight G_1")
    permanent_load_kN: float = key("G_2, loads of the project file", "Permanenti G_2|Permanent G_2")
    variable_load_kN: float = key("Q, characteristic", "Variabili Q|Variable Q")
    use_category: str | None = key("category of Q, NTC 2018 Tab. 2.5.I; null: none", "Categoria|Category")
    psi_2: float | None = key("its ψ₂; null: no variable load", "ψ_2")
    combined_kN: float = key("G_1 + G_2 + ψ₂ Q", "G_1 + G_2 + ψ_2 Q")
    seismic_weight_kN: float = key("what of it is seismic mass", "W_s")


class Control(Part):
    """`geometry.controls[]`: a control point."""

    name: str = key("name in the project file")
    point_m: Point = key("x, z as drawn")
    block: int = key("number of the block that it moves with")


class Face(Part):
    """A pair of faces that may press on each other."""

    blocks: list[int] = key("numbers of the two blocks")
    middle_m: list[Point] = key("a point of the face of either block, from which slips count: x, z")
    faces_m: list[list[Point]] = key("start and end of the face of either block, as drawn: x, z")
    friction: float | None = key("coefficient of friction; null: it does not slide", "Attrito|Friction")
    depth_m: float = key("depth out of plane, the lesser of the two")
    compressive_strength_kN_m2: float | None = key("null: no limit", "Resistenza|Strength", shown="MPa")


class Joint(Face):
    """`geometry.joints[]`: a joint of the drawing; its number is its place in this list, from 0."""

    ends_m: list[Point] = key("the two ends of the joint as drawn: x, z")


class Geometry(Part):
    """`geometry`: blocks, joints and control points as read from the drawing."""

    blocks: list[DrawnBlock] = key("the blocks")
    controls: list[Control] = key("the control points, the default one first")
    joints: list[Joint] = key("the joints")
    origin_m: Point | None = optional("of a drawing far from (0, 0): where hand checks count from")
    cracks_m: list[list[Point]] | None = optional("surveyed cracks of the drawing, lines: x, z")
    joint_tolerance_m: float = key("edges closer than this form a joint")
    gravity_m_s2: float = key("acceleration of gravity")


class Echo(Part):
    """`echo`: the project file as it was read, defaults filled in; the keys of its tables are in `assesto schema`."""

    title: str = key("title of the project")
    accuracy: str | float | None = optional("a name, or a relative tolerance")
    scatter: int | None = optional("members of each small ensemble")
    geometry: dict[str, Any] = key("[geometry]")
    material: dict[str, Any] = key("[material]")
    layers: dict[str, dict[str, Any]] | None = optional("[layers]")
    region: list[dict[str, Any]] | None = optional("[[region]], as given: without defaults")
    contacts: dict[str, Any] | None = optional("[contacts]")
    control: list[dict[str, Any]] | None = optional("[[control]]")
    settlements: list[dict[str, Any]] | None = optional("[[settlements]]")
    tie: list[dict[str, Any]] | None = optional("[[tie]]")
    strengthening: list[dict[str, Any]] | None = optional("[[strengthening]]")
    pushover: dict[str, Any] | None = optional("[pushover]")
    history: list[dict[str, Any]] | None = optional("[[history]]")
    incremental: dict[str, Any] | None = optional("[incremental]")
    campaign: dict[str, Any] | None = optional("[campaign]")
    assessment: dict[str, Any] | None = optional("[assessment]")
    mechanism: list[dict[str, Any]] | None = optional("[[mechanism]]")
    sensitivity: dict[str, Any] | None = optional("[sensitivity]")
    identification: dict[str, Any] | None = optional("[identification]")
    measurement: list[dict[str, Any]] | None = optional("[[measurement]]")
    report: dict[str, Any] = key("[report]")


class Software(Part):
    """`software`: what the results were computed with."""

    version: str = key("version of assesto")
    python: str = key("version of Python")
    platform: str = key("operating system")
    packages: dict[str, str] = key("versions of the libraries by name")


class Certificates(Part):
    """How many programs were solved, and the worst of their certificates; null or missing: none of the kind."""

    solves: int = key("programs solved", "Problemi|Programs")
    worst_equilibrium_residual: float | None = optional(
        "largest unbalanced force, per weight", "Equilibrio|Equilibrium", digits=2
    )
    worst_penetration_m: float | None = optional("deepest of blocks", "Compenetr.|Penetration", shown="mm")
    worst_complementarity: float | None = optional(
        "largest contact force times its gap, per weight and step", "Complem.", digits=2
    )
    worst_cone_violation: float | None = optional("out of the cone, per weight", "Attrito|Friction", digits=2)


WORST = tuple(name for name in Certificates.model_fields if name.startswith("worst_"))


class QualityRow(Certificates):
    """`quality.by_stage[]`: the worst certificate of the programs that an analysis solved."""

    state: str | None = key("state; null: of several")
    stage: str = key("which analysis", "Fase|Stage")
    lifting: int | None = optional("points solved with dilation, where Coulomb's law was not; missing: none")


class Quality(Certificates):
    """`quality`: the certificates of all programs, and every warning of the run."""

    warnings: list[Sentence] = key("what the reader has to know")
    by_stage: list[QualityRow] = key("the same of every analysis")


class Line(Part):
    """A line of a calculation (`trace[]`): symbol = formula(inputs) = result."""

    symbol: str = key("name of the result", "Simbolo|Symbol")
    formula: str = key("plain arithmetic in the names of the inputs; empty: a datum", "Formula")
    inputs: dict[str, float] = key("the numbers put in", "Dati|Data", words=True)
    result: float = key("the result, in the unit of `unit`", "Risultato|Result")
    unit: str = key("unit of the result")
    paragraph: Sentence = key("paragraph of the standard, or source of a datum", "Riferimento|Reference")
