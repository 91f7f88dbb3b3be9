"""Hostile values, names and texts."""

import re

from hypothesis import strategies as st


def _words(text: str) -> list[str]:
    return text.split()


PLAUSIBLE = _words("1 2 3.5 0.01 0.1 100 1e3 1e-3 1e4 1e5 -0.5 0.5 35")
EXTREME = _words(
    "0 -0.0 -1 1e-300 -1e-300 5e-324 1e160 1e300 -1e300 1e308 1e400 -1e400 nan inf -inf 1e-12 1e-9 1e7 1e9 1e16"
)
NUMBERS = [*PLAUSIBLE, *EXTREME, "9" * 30, "9" * 400, "0x" + "f" * 5000]
TEXTS = [
    "", " ", "\\u0000", "\\u001b[31m", "\\u202e", "=1+1", "x" * 3000, "../../x", "/", "/**/*", "*/*",
    "elastic",
]  # fmt: skip
TABLES = _words(
    '[] [[]] {} true false 2009-04-06 12:00:00 [1,2,3] [nan,inf] [1e400,0] [""] {a.b.c=1} ["a","a"] [1, = 0,6 1_0 +x'
)
VALUES = [*NUMBERS, *(f'"{text}"' for text in TEXTS), *TABLES, "[" * 60 + "]" * 60, "'''", '"""', "\\"]
NAMES = [
    *_words(
        "=HYPERLINK(0) +1 -1 @x $x_1$ $ \\frac _hidden {0} {state} %s &amp; \" ' ` .. / \\ CON nul [x] [/x] [bold]"
    ),
    *_words("<script>alert(1)</script> </svg> ]]> --> original +x -x key inf nan null #N/A TRUE _x0041_ 中文 🏛️ ℵ"),
    *("\x1b[2J", "\x07", "\x9b31m", "a\nb", "a\rb", "a\tb", "\u202ename", "\ufeff", "\u200d", "e\u0301", "a" * 200),
    *("a: b: c: d", "a, b contacts: c", "x; y; z", "rotate(-0 ", "..." * 60, ": " * 90),
]  # fmt: skip

numbers = st.sampled_from(NUMBERS)
values = st.sampled_from(VALUES)
names = st.sampled_from(NAMES) | st.text(max_size=30)


@st.composite
def damaged_bytes(draw: st.DrawFn, whole: bytes) -> bytes:
    """Bytes of a good file, cut off, overwritten, doubled or left out in places."""
    raw = bytearray(whole)
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        at = draw(st.integers(0, max(0, len(raw) - 1)))
        length = draw(st.sampled_from((1, 2, 8, 64, 512)))
        how = draw(st.sampled_from(("cut", "overwrite", "double", "drop", "noise")))
        if how == "cut":
            del raw[at:]
        elif how == "overwrite":
            raw[at : at + 1] = draw(st.sampled_from((b"\x00", b"\xff", b"\n", b'"', b"9", b"-", b"<", b"e")))
        elif how == "double":
            raw[at:at] = raw[at : at + length]
        elif how == "drop":
            del raw[at : at + length]
        else:
            raw[at:at] = draw(st.binary(max_size=8))
    return bytes(raw)


@st.composite
def damaged_lines(draw: st.DrawFn, text: str, hostile: st.SearchStrategy[str]) -> str:
    """Lines of a good text with some left out, doubled, exchanged, or their numbers and words made hostile."""
    lines = text.splitlines()
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        at = draw(st.integers(0, len(lines) - 1))
        how = draw(st.sampled_from(("value", "value", "value", "drop", "double", "swap", "own")))
        if how == "value":
            lines[at] = replaced(lines[at], draw(hostile), draw(st.integers(0, 5)))
        elif how == "drop":
            del lines[at : at + draw(st.sampled_from((1, 1, 3, 20)))]
        elif how == "double":
            lines.insert(at, lines[at])
        elif how == "swap":
            other = draw(st.integers(0, len(lines) - 1))
            lines[at], lines[other] = lines[other], lines[at]
        else:
            lines[at] = draw(hostile)
        lines = lines or [""]
    return "\n".join(lines)


def replaced(line: str, value: str, which: int) -> str:
    """Return a line with one of its values replaced: what follows a = sign, or one of its numbers or words."""
    key, sign, _ = line.partition(" = ")
    if sign:
        return f"{key} = {value}"
    words = list(re.finditer(r"[^\s,;]+", line))
    if not words:
        return value
    word = words[which % len(words)]
    return line[: word.start()] + value + line[word.end() :]
