"""The built-in templates: a new project from a few dimensions; their names, each that of its function too."""

NAMES = (
    "block", "wall", "wall-with-openings", "facade", "tympanum", "bell-gable", "arch", "pointed-arch",
    "buttressed-arch", "arcade", "barrel-vault", "triumphal-arch",
)  # fmt: skip
