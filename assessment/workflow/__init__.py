"""A run: which analyses a project needs, in what order, and what they leave in the output folder."""

STAGES = {  # that a run may be asked for, and the table of the project that each needs
    "pushdown": "settlements",
    "pushover": "pushover",
    "history": "history",
    "incremental": "incremental",
    "campaign": "campaign",
    "assessment": "assessment",
    "scenarios": "settlements",
    "sensitivity": "sensitivity",
    "identification": "identification",
}
