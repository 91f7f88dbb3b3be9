# make run | test | docs | benchmark | clean; all but clean first build the environment in .venv.
.PHONY: run test docs benchmark setup clean

run: setup
	.venv/bin/assesto run projects/buttressed_arch --only assessment

test: setup
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-cache
	.venv/bin/python -m pytest -n 2 --dist loadfile

docs: setup
	.venv/bin/python -m sphinx -q -W --keep-going -b html docs build/docs

benchmark: setup
	.venv/bin/assesto benchmark

setup:
	@sh tools/setup.sh

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis projects/*/output benchmark
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
