# One word for each thing a developer or a user wants. `tools/setup.py` makes .venv, the object
# detector and the pages when they are missing or out of date, and takes no time when they are not.
PYTHON ?= python3
# One that somebody names is used; else the system's may be, where it is much quicker.
ifneq ($(origin PYTHON),file)
export TALAIA_THIS_PYTHON := 1
endif
VENV := .venv/bin
.DEFAULT_GOAL := help
.PHONY: help setup demo demo-indi test test-quick coverage proofs check bench bench-peers faults fuzz soak docs site lock pages clean

help:  ## list the words
	@grep -E '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /\t/' | expand -t 12

setup:  ## everything a developer needs, in .venv and web/node_modules
	@$(PYTHON) tools/setup.py dev

demo:  ## the product with a simulated vehicle, in your browser
	@$(PYTHON) tools/setup.py demo
	@exec $(VENV)/talaia demo $(ARGS)

demo-indi:  ## the product with an observatory on INDI's own simulators
	@$(PYTHON) tools/setup.py demo
	@exec $(VENV)/talaia demo-indi $(ARGS)

test: setup  ## all tests: Python with real ROS 2 and Chromium, and the pages'
	$(VENV)/python tools/run_tests.py $(ARGS)

test-quick: setup  ## the tests that start nothing; under two minutes
	$(VENV)/python tools/run_tests.py --quick $(ARGS)

coverage: setup  ## `make test`, with the line coverage of all of it (slower)
	$(VENV)/python tools/run_tests.py --coverage $(ARGS)

proofs: setup  ## hours: what takes too long for each change (ONLY=name, AGAIN=1)
	$(VENV)/python tools/proofs.py $(ONLY) $(if $(AGAIN),--again)

check: setup  ## style, types, import direction, generated files
	$(VENV)/ruff check .
	$(VENV)/ruff format --check .
	$(VENV)/mypy
	$(VENV)/lint-imports
	$(VENV)/python tools/generate_web_types.py --check
	$(VENV)/python tools/generate_reference.py --check
	$(VENV)/python tools/generate_asyncapi.py --check
	$(VENV)/python tools/generate_hub_sentences.py --check
	$(VENV)/python tools/generate_notice.py --check
	$(VENV)/python tools/check_tree.py
	$(VENV)/python tools/check_tests.py
	$(VENV)/python tools/check_names.py
	$(VENV)/python tools/check_pages.py
	$(VENV)/python tools/build_site.py
	$(VENV)/python tools/node.py run check

bench: setup  ## measure speed and memory; prints each figure beside its limit
	$(VENV)/python bench/run.py $(ARGS)

bench-peers: setup  ## measure Talaia beside others, each installed for it and removed again
	$(VENV)/python bench/peers.py docs/beside-table.md

faults: setup  ## `make proofs ONLY=faults`, again; MINUTES=5 for a short look, not written down
	$(VENV)/python tools/proofs.py faults --again $(if $(MINUTES),--minutes $(MINUTES))

fuzz: setup  ## `make proofs ONLY=fuzz`, again; MINUTES=5 for a short look, not written down
	$(VENV)/python tools/proofs.py fuzz --again $(if $(MINUTES),--minutes $(MINUTES))

soak: setup  ## hub and gateway for 2 hours (HOURS=24 before a release), and what grows
	PYTHONPATH=src:tests $(VENV)/python -m system.soak $(or $(HOURS),2) \
	--table docs/soak-table.md --samples build/soak.jsonl $(ARGS)

docs: setup  ## write docs/reference from the code
	$(VENV)/python tools/generate_reference.py
	$(VENV)/python tools/generate_asyncapi.py
	$(VENV)/python tools/generate_hub_sentences.py
	$(VENV)/python tools/generate_notice.py
	$(VENV)/python tools/generate_web_types.py

site: setup  ## build the documentation site in build/docs (ARGS="--version 1.2 --source URL")
	$(VENV)/python tools/build_site.py $(ARGS)

lock: setup  ## resolve the Python lock files anew
	$(VENV)/python tools/lock.py

pages: setup  ## build the pages
	$(VENV)/python tools/node.py run build

clean:  ## remove what `setup` made
	rm -rf .venv web/node_modules src/talaia/web/static src/talaia/objects/models
