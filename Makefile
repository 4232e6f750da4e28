# These commands do all set-up on a fresh machine with Python 3.11 or newer:
#   make demo    makes an environment in .venv, renders the demo strip into demo/
#   make test    adds what the tests need, then formatting, lint, types and tests
#   make docs    builds the site into build/site/html
# They need the network the first time only.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

# What compiles and runs exported shaders besides pip's packages: compilers, drivers that need no GPU, and
# libraries of Blender's Python package. slangtorch (slangc) and bpy (OSL) come without their dependencies.
PROVE_PACKAGES := glslangValidator=glslang-tools spirv-opt=spirv-tools libEGL.so.1=libegl1 \
    libGL.so.1=libgl1 libvulkan.so.1=libvulkan1 libvulkan_lvp.so=mesa-vulkan-drivers libSM.so.6=libsm6 \
    libXi.so.6=libxi6 libXfixes.so.3=libxfixes3 libXrender.so.1=libxrender1 libxkbcommon.so.0=libxkbcommon0

# The browser in which 'gonio view' is tested, and what builds its script again.
VIEW_PACKAGES := chromium=chromium node=nodejs npm=npm

.PHONY: help demo test format docs bench field golden layers clean

help:
	@sed -n '2,5s/^# *//p' Makefile

demo: $(VENV)/.installed
	$(BIN)/gonio demo

test: $(VENV)/.installed-test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto --maxprocesses 4 --dist worksteal

format: $(VENV)/.installed-test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# What has been reproduced is kept, and made again where the code has changed.
docs: $(VENV)/.installed-docs
	$(BIN)/gonio reproduce --all
	$(BIN)/python tools/make_site.py

bench: $(VENV)/.installed
	$(BIN)/gonio bench --output docs/performance.md

golden: $(VENV)/.installed
	$(BIN)/python tools/make_golden.py
	$(BIN)/python tools/make_stubs.py

# BRDF_EXPLORER=FOLDER judges its .brdf files as well.
field: $(VENV)/.installed-test
	$(BIN)/python tools/make_field_page.py $(if $(BRDF_EXPLORER),--brdf-explorer $(BRDF_EXPLORER))

layers: $(VENV)/.installed
	$(BIN)/python tools/make_layers_page.py

$(VENV)/bin/python:
	PYTHON=$(PYTHON) sh .ci/system-packages
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "gonio needs Python 3.11 or newer; set PYTHON=python3.x")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) -e .
	touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(INSTALL) -e '.[docs]'
	touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	PYTHON=$(PYTHON) sh .ci/system-packages g++ $(PROVE_PACKAGES) $(VIEW_PACKAGES)
	$(INSTALL) -e '.[test]'
	for folder in gonio/view/web examples/hosts; do \
	    npm ci --prefix $$folder --ignore-scripts --no-audit --no-fund --silent || exit 1; done
	$(INSTALL) --no-deps slangtorch 'bpy; python_version == "3.11"'
	touch $@

clean:
	rm -rf $(VENV) demo build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
