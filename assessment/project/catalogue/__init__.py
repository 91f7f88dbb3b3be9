"""The built-in templates: a new project from a few dimensions; their names, each that of its function too."""

WALLS = ("block", "wall", "wall-with-openings", "facade", "tympanum", "bell-gable")
ARCHES = ("arch", "pointed-arch", "buttressed-arch", "arcade", "barrel-vault", "triumphal-arch")
