"""Tables of cases as text."""


def rows(text: str) -> list[tuple[str, ...]]:
    """Return the fields of each line, between bars; \\n in one is a line's end, what is indented goes on with the last.

    Lines that begin with # are headings for the reader.
    """
    lines = text.replace("\n    ", " ").splitlines()
    told = (line.split("|") for line in lines if "|" in line and not line.startswith("# "))
    return [tuple(field.strip().replace("\\n", "\n") for field in fields) for fields in told]
