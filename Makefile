# make run | test | least | docs | benchmark | clean; all but clean first build the environment in .venv.
.PHONY: run test least docs benchmark checks loops setup clean

run: loops
	.venv/bin/assesto run projects/buttressed_arch

test: checks loops
	.venv/bin/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder  # the long files are the first

checks: setup
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-cache

loops: setup  # compiled once for an environment: `make -j2` does it beside the checks
	@[ .venv/.loops -nt .venv/.ready ] || { .venv/bin/python tools/compile_loops.py && touch .venv/.loops; }

least: setup  # comparisons with closed forms and a run, on the least versions that pyproject.toml allows
	.venv/bin/python -m venv --clear build/least
	.venv/bin/python tools/least_versions.py > build/least/versions.txt
	build/least/bin/python -m pip install --quiet -r build/least/versions.txt pytest hypothesis pypdf
	PYTHONPATH=. build/least/bin/python -m pytest tests/validation
	PYTHONPATH=. build/least/bin/python -m assessment.cli run projects/rocking_block --out build/least/output

docs: setup
	.venv/bin/python -m sphinx -q -W --keep-going -b html docs build/docs

benchmark: loops
	.venv/bin/assesto benchmark

setup:
	@sh tools/setup.sh

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis projects/*/output benchmark
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
