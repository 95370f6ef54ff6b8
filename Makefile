# The two commands that do all the set-up: `make demo` and `make test`.
# They need Python 3.11 or later with venv; everything else is installed into .venv.

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/ready

.PHONY: demo test check format bench speed pictures lock clean

demo: $(READY)
	$(BIN)/mien demo --out demo

test: $(READY) validator
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto

check: test

$(READY): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("mien needs Python 3.11 or later; run: make PYTHON=python3.11") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $(READY)

# The Khronos glTF validator, where Node.js is there to run it; its tests are skipped otherwise.
.PHONY: validator
validator:
	@if command -v npm >/dev/null && [ ! -d tests/tools/node_modules ]; then \
		npm install --prefix tests/tools --no-package-lock --no-audit --no-fund --silent || echo "the glTF validator could not be installed; its tests are skipped"; \
	fi

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# Every method on the built-in cases, against the committed baseline.
bench: $(READY)
	$(BIN)/mien bench --embedded --gate benchmarks/results/bench_quick.json

speed: $(READY)
	$(BIN)/python -m benchmarks.speed.alignment
	$(BIN)/python -m benchmarks.speed.solve
	$(BIN)/python -m benchmarks.speed.whole

pictures: $(READY)
	$(BIN)/python docs/make_pictures.py

lock: $(READY)
	$(BIN)/pip install --quiet uv
	$(BIN)/uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --generate-hashes --no-annotate --no-header --no-emit-index-url -o requirements.lock

clean:
	rm -rf .venv demo
