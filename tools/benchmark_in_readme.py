"""Put the summary of `assesto benchmark` into the README: give its path, benchmark/summary.md."""

import sys
from pathlib import Path

BEGIN, END = "<!-- begin: summary.md of assesto benchmark -->\n", "<!-- end -->\n"

readme = Path(__file__).parents[1] / "README.md"
before, _, rest = readme.read_text(encoding="utf-8").partition(BEGIN)
after = rest.partition(END)[2]
summary = Path(sys.argv[1]).read_text(encoding="utf-8")
readme.write_text(f"{before}{BEGIN}\n{summary}\n{END}{after}", encoding="utf-8")
