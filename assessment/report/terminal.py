"""What the terminal tells of results: the sentences and the table of the report, in English, and the model."""

from assessment.report.language import Words, plain_text
from assessment.results.schema import Results
from assessment.results.summary import best_of, fits, movement_text, settlement_lines


def told(results: Results) -> str:
    """Return what was found, the model, a table by state and direction, and the best movement of an identification."""
    from assessment.report.chapters.judgement import findings  # late: `assesto check` tells of a model alone
    from assessment.report.chapters.synthesis import synthesis_grid

    words = Words.of("en")
    lines = [*map(plain_text, findings(results, words)), "", model_summary(results)]
    if grid := synthesis_grid(results, words):
        texts = [[plain_text(cell) for cell in row] for row in (grid.head, *grid.rows)]
        widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
        lines += ["  ".join(map(str.ljust, row, widths)).rstrip() for row in texts]
    identified = results.identification
    if identified and (best := best_of(identified)):  # as the project file has it too
        moved, freedom = "; ".join(map(movement_text, best.movement)), best.degrees_of_freedom
        lines.append(f"best movement: {moved} (χ² {best.chi_squared:.3g}, {freedom} degrees of freedom)")
        if identified.settlements and not fits(best):
            lines.append("  # does not fit the measurements: not to be used")
        lines += [f"  {line}" for ready in identified.settlements for line in settlement_lines(ready)]
    return "\n".join(lines)


def model_summary(results: Results) -> str:
    """Return a summary of the model, a few lines."""
    model = results.model
    ties = f", ties {len(model.ties)}" if model.ties else ""
    stands = "yes" if model.self_weight_stable else "NO"
    return (
        f"{results.title}\n"
        f"  blocks {model.blocks} ({model.movable_blocks} movable), joints {model.joints}, unknowns {model.unknowns}"
        f"{ties}\n  weight {model.weight_kN:.4g} kN; stands under its own weight: {stands}"
    )
