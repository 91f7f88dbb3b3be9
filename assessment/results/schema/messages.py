"""What the sentences of results.json are made of, for a report in another language."""

from __future__ import annotations

from assessment.results.schema.part import Part, key


class Worded(Part):
    """`messages.SENTENCE`: the template of a sentence, with what fills it; a report words it in its own language."""

    template: str = key("the English sentence with named fields, {name:format}")
    fields: dict[str, str | int | float | Worded | list[str | int | float | Worded]] = key(
        "text, number or sentence of each field, or a list of them"
    )
