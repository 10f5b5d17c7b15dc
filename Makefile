# make worlds   sets up and generates every example into worlds/
# make test     sets up, with a real Gazebo where this machine allows one, and tests every promise: a quarter of an hour on two cores
# make test-all    these and the long tests in one run: half an hour to three quarters on two cores
# make test-fast   the tests without a simulator, a browser and all that is slow: four minutes on two cores; WHAT=scanning
#               those of one folder of src/rsegen, WHAT="scanning heights" of two
# make deletions   deletes each capability in turn, in a copy, and runs the fast tests that are left; WHAT=scanning for one of them
# make coverage  the tests of the core in a copy without anything else, and which of its lines they do not run
# make mutants  which small changes to the core no test notices; MUTANTS=obstacles/peak.py or MUTANTS=50, a sample
# make fuzz     tries hostile input on every reader and command; FUZZ="--cases 100000 --seed 7" for an hour of it
# make crash    kills commands, and lets their calls fail, at random calls; CRASH="--trials 2000 --seed 7 --experiments 4"
# make check    lint, types, import contracts
# make package  builds wheel and sdist into dist/ and tries the wheel
# make page     makes the page's scripts anew after a change in src/rsegen/page/browser/app
# make docs     makes the generated parts of the manual and its pictures anew
# make site     the manual as a site, in build/site
# make bench    measures speed, memory and face counts beside other ways; BENCH=--quick for two minutes, not kept; BENCH=--starts for starts alone, kept
# make bench-contact   ranks collision constructions in a real Gazebo; QUICK=--quick in a few minutes
# make bench-experiment   the paper's tables in a real Gazebo, half an hour
# Without bytecode a process takes twice the time to collect the tests, and each start of rsegen half as long again.
unexport PYTHONDONTWRITEBYTECODE
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# A process that has no more tests takes some of another's. Many wait for servers and browsers, so there is a process more
# than there are cores.
ARGS ?= --numprocesses=$$(( $$(getconf _NPROCESSORS_ONLN) + 1 )) --dist=worksteal
FAST ?= --numprocesses=2
WHAT ?=
MUTANTS ?=
FUZZ ?=
# Of the long tests one in so many, those that a commit draws; all without a number.
LONG_SHARE ?=
CRASH ?=
# What tests and developers need, 2 GB, in a fifth of pip's time.
UV := $(BIN)/uv pip install --quiet --python
LOCK := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 pyproject.toml --custom-compile-command 'make lock'

.PHONY: browser npm classic compiler learners worlds test test-all test-fast deletions coverage mutants fuzz crash check page docs site package gazebo screen lock bench bench-contact bench-experiment bench-isaaclab

worlds: $(VENV)/installed
	@for recipe in src/rsegen/recipe/examples/*.yaml; do \
		echo "$$recipe"; $(BIN)/rsegen generate $$recipe -o worlds --preview --force --quiet || exit; \
	done
	@echo "the worlds are in worlds/; look at one, and change it: $(BIN)/rsegen gui mixed-course"

test: $(VENV)/tester classic screen browser npm compiler
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest -m "not long" $(ARGS)

test-all: $(VENV)/developer gazebo screen browser npm compiler learners
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest $(if $(LONG_SHARE),--long-share=$(LONG_SHARE)) $(ARGS)

test-fast: $(VENV)/tester
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest -m "not slow and not long and not real" $(FAST) $(addprefix tests/,$(WHAT))

deletions: $(VENV)/tester
	$(BIN)/python -m tests.support.deletion $(WHAT)

# Apart from make test, as to watch each line makes tests half as slow again.
coverage: $(VENV)/developer
	$(BIN)/python -m tests.support.deletion --all

mutants: $(VENV)/developer
	$(BIN)/python -m tests.support.mutants $(MUTANTS)

fuzz: $(VENV)/developer
	$(BIN)/python -m tests.fuzz $(FUZZ)
	$(BIN)/python -m tests.fuzz --family wire --cases 200
	$(BIN)/python -m tests.fuzz --family page --cases 100
	$(BIN)/python -m tests.fuzz --family field --cases 200

crash: $(VENV)/developer compiler
	$(BIN)/python -m tests.crash $(CRASH)

check: $(VENV)/developer
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m docs.generate --check
	scripts/page --check || test $$? = 3

page:
	scripts/page

docs: $(VENV)/developer
	$(BIN)/python -m docs.generate

# Links and docstrings that are not right are errors. The course to look at is made here, as it is large.
site: $(VENV)/developer
	$(BIN)/rsegen view mixed-course --look wood -o docs/course.html --force
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

bench: $(VENV)/developer
	$(BIN)/python -m benchmarks.speed $(if $(wildcard $(VENV)/isaaclab),--isaaclab $(VENV)/isaaclab/bin/python) $(BENCH)
	$(BIN)/python -m docs.generate

# IsaacLab, to be measured beside: the one function needs no simulator.
bench-isaaclab:
	$(PYTHON) -m venv $(VENV)/isaaclab
	$(VENV)/isaaclab/bin/pip install --quiet torch trimesh scipy
	$(VENV)/isaaclab/bin/pip install --quiet --no-deps isaaclab==2.3.2.post1

# The wheel, installed into an environment of its own, makes a world.
package: $(VENV)/developer
	rm -rf dist $(VENV)/package
	$(BIN)/python -m build --installer uv --outdir dist . >/dev/null
	$(PYTHON) -m venv --without-pip $(VENV)/package
	$(UV) $(VENV)/package/bin/python dist/*.whl
	$(VENV)/package/bin/rsegen generate peak -o $(VENV)/package/worlds
	$(VENV)/package/bin/rsegen generate --seed 1 --obstacle 'random levels=5' -o $(VENV)/package/worlds

bench-contact: $(VENV)/developer gazebo
	$(BIN)/python -m benchmarks.contact $(QUICK)

# The paper's tables on this machine, which should have nothing else to do: half an hour.
bench-experiment: $(VENV)/developer gazebo
	$(BIN)/rsegen experiment paper -o $(VENV)/experiment
	cp $(VENV)/experiment/summary.json benchmarks/results/experiment.json
	$(BIN)/python -m docs.generate

# A real simulator for the tests, set up where it is missing; where that cannot be, the tests that need it say so.
classic:
	scripts/gazebo-classic || test $$? = 3
	scripts/sdformat || test $$? = 3

# All that judges worlds and packages of ROS 2.
gazebo: classic
	scripts/gazebo-sim || test $$? = 1
	scripts/gazebo-engine || test $$? = 3
	scripts/ros2 || test $$? = 3

# mjlab and SAPIEN for the tests of what plugs into them, without what they need for training; where they cannot be, they say so.
learners: $(VENV)/developer
	test -d $(VENV)/mjlab || $(UV) $(BIN)/python --no-deps --target $(VENV)/mjlab mjlab==1.6.0 || rm -rf $(VENV)/mjlab
	test -d $(VENV)/sapien || $(UV) $(BIN)/python --no-deps --target $(VENV)/sapien sapien==3.0.3 transforms3d || rm -rf $(VENV)/sapien

# A screen on which the cameras of simulators draw.
screen:
	scripts/screen || test $$? = 3

# A C compiler for the trials of tests/crash, which make calls of the C library fail.
compiler:
	scripts/packages compiler gcc libc6-dev || test $$? = 3

# A browser for the tests of the page.
browser:
	scripts/browser || test $$? = 3

# What makes the page's scripts, and judges them.
npm:
	scripts/page --install || test $$? = 3

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	@echo "downloading rsegen's requirements (numpy, matplotlib and a few more, 55 MB) into $(VENV)"
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/tester: $(VENV)/installed test.lock
	$(BIN)/python -m pip install --quiet uv
	$(UV) $(BIN)/python --requirement test.lock
	touch $@

$(VENV)/developer: $(VENV)/tester dev.lock
	$(UV) $(BIN)/python --requirement dev.lock
	touch $@

# The developers' tools, each in one version, and those of them that make test needs: make lock, then make test-all.
lock: $(VENV)/tester
	$(LOCK) --group dev -o dev.lock
	$(LOCK) --group test --constraints dev.lock -o test.lock
