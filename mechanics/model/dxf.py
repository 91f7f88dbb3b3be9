"""A DXF file as a document: what can be read without loss is, and what cannot is refused."""

from __future__ import annotations

import logging
import re
import struct
from io import BytesIO, StringIO
from pathlib import Path

from ezdxf import recover
from ezdxf._options import options
from ezdxf.audit import AuditError
from ezdxf.document import Drawing as Document
from ezdxf.filemanagement import readfile
from ezdxf.lldxf.const import DXFError, DXFStructureError

from mechanics.errors import DrawingError
from mechanics.faults import visible
from mechanics.messages import Message, message

MOST_BYTES = 200_000_000  # of a file: some 20 000 blocks take ten
LONGEST_REASON = 300  # letters of a message of ezdxf
ENTITIES = re.compile(rb"[2\x02][\s\x00]*ENTITIES[\s\x00]")
END = re.compile(rb"ENDSEC|SECTION|EOF")
UNPARSED = (DXFError, OSError, struct.error, AssertionError, StopIteration, ArithmeticError, RecursionError)
MISLEADING = {AuditError.INVALID_FLOATING_POINT_VALUE, AuditError.INVALID_BLOCK_REFERENCE_CYCLE}
VERSION = re.compile(rb"(\$ACADVER\s+1\s+)(AC\d+)")
HEADER = re.compile(rb"(?m)^([ \t]*2[ \t]*\r?\n[ \t]*HEADER[ \t]*\r?\n)")
# an LWPOLYLINE and its pairs of group code and value
LWPOLYLINE = re.compile(
    rb"(?m)^([ \t]*0[ \t]*\r?\n[ \t]*LWPOLYLINE[ \t]*\r?\n)((?:[ \t]*[1-9]\d*[ \t]*\r?\n[^\n]*\n)*)"
)
OF_DATABASE = {5, 102, 330, 360}  # group codes of what any entity has, before those of its kind
OF_ENTITY = {8, 6, 62, 48, 60, 67, 370, 420, 430, 440, 347, 348, 390, 410, 284, 92, 160, 310}
R13, R2000 = b"AC1012", b"AC1015"  # the first version with subclasses, and what older ones are read as

logging.getLogger("ezdxf").addHandler(
    logging.NullHandler()
)  # its findings are reported here, in our own words


def open_document(path: Path) -> tuple[Document, list[Message]]:
    """Return the document, repaired where that loses nothing, and warnings of that.

    Raises DrawingError where it cannot be read.
    """
    try:
        size = path.stat().st_size
        data = path.read_bytes() if 0 < size <= MOST_BYTES else b""  # what has no size may have no end
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", error)
        raise DrawingError(f"{path}: cannot be read ({why}); give the path of a DXF file") from None
    if size > MOST_BYTES:
        raise DrawingError(
            f"{path}: {size:.3g} bytes, at most {MOST_BYTES:.3g}; keep only what is to be analysed"
        )
    if data.startswith(b"AC10"):
        raise DrawingError(f"{path}: this is a DWG drawing; save it as DXF")
    if b"SECTION" not in data:
        raise DrawingError(f"{path}: this is no DXF drawing; export the drawing as DXF")
    begin = ENTITIES.search(data)
    if begin is None or END.search(data, begin.end()) is None:
        raise DrawingError(f"{path}: the file is cut off before the end of its entities; export it again")
    warnings: list[Message] = []
    try:
        if data.startswith(b"AutoCAD Binary DXF"):
            document = readfile(path)  # recover mode is for text only
            auditor = document.audit()
        else:
            data, warnings = _as_of_today(data if b"\n" in data else data.replace(b"\r", b"\n"))
            document, auditor = recover.read(BytesIO(data))
    except (*UNPARSED, ValueError, LookupError, TypeError, AttributeError) as error:
        why = f" ({visible(str(error))[:LONGEST_REASON]})" if isinstance(error, DXFStructureError) else ""
        raise DrawingError(f"{path}: the file is damaged{why}; export it again") from error
    faults = [*auditor.errors, *auditor.fixes]
    if warnings:  # older tables have no handles
        faults = [fault for fault in faults if fault.code != AuditError.INVALID_TABLE_HANDLE]
    if fatal := [visible(fault.message)[:LONGEST_REASON] for fault in faults if fault.code in MISLEADING]:
        raise DrawingError(f"{path}: the file is damaged: {'; '.join(fatal[:3])}; export it again")
    if faults:
        warnings.append(
            message(
                "the file was damaged and has been repaired ({count} faults, first: {found}); "
                "compare the model with the drawing",
                count=len(faults),
                found=visible(faults[0].message)[:LONGEST_REASON],
            )
        )
    return document, warnings


def dxf_bytes(document: Document) -> bytes:
    """Return a document that was read as a DXF text file, without times and random identifiers: the same each time."""
    before, options.write_fixed_meta_data_for_testing = options.write_fixed_meta_data_for_testing, True
    try:
        text = StringIO()
        document.write(text)
    finally:
        options.write_fixed_meta_data_for_testing = before
    return text.getvalue().encode(document.output_encoding, errors="dxfreplace")


def _as_of_today(data: bytes) -> tuple[bytes, list[Message]]:
    """Return a text file whose LWPOLYLINEs are those of R2000, whatever its header says, and a warning of a change.

    Some programs write them into files of older versions or of none, or without the markers of their subclasses.
    """
    named = VERSION.search(data)
    old = named is None or named[2] < R13
    if not (old or b"AcDbPolyline" not in data or data.count(b"LWPOLYLINE") > data.count(b"AcDbPolyline")):
        return data, []
    changed = 0

    def marked(found: re.Match[bytes]) -> bytes:
        nonlocal changed
        lines = found[2].split(b"\n")
        pairs = [(int(code), value) for code, value in zip(lines[:-1:2], lines[1::2], strict=True)]
        if not old and any(code == 100 and value.strip() == b"AcDbPolyline" for code, value in pairs):
            return found[0]
        changed += 1
        own = [pair for pair in pairs if pair[0] != 100]
        base = [pair for pair in own if pair[0] in OF_DATABASE]
        common = [pair for pair in own if pair[0] in OF_ENTITY]
        rest = [pair for pair in own if pair[0] not in OF_DATABASE | OF_ENTITY]
        whole = [*base, (100, b"AcDbEntity"), *common, (100, b"AcDbPolyline"), *rest]
        return found[1] + b"".join(b"%d\n%s\n" % pair for pair in whole)

    data = LWPOLYLINE.sub(marked, data)
    if not changed:
        return data, []
    variable = b"  9\n$ACADVER\n  1\n" + R2000 + b"\n"
    if named and old:
        data = VERSION.sub(rb"\g<1>" + R2000, data, count=1)
    elif named is None and HEADER.search(data):
        data = HEADER.sub(rb"\g<1>" + variable.replace(b"\\", b""), data, count=1)
    elif named is None:
        data = b"  0\nSECTION\n  2\nHEADER\n" + variable + b"  0\nENDSEC\n" + data
    told = message(
        "LWPOLYLINEs without their subclass, or in a file of version {version}: {count}, read as what they are",
        version=named[2].decode() if named else "–",
        count=changed,
    )
    return data, [told]
