"""Random Step Environments (NIST stepfields) for robot simulators.

import rsegen

recipe = rsegen.Recipe(
    seed=7,
    obstacles=[
        rsegen.Random(levels=5),
        rsegen.Peak(levels=5, softness=50, first=(2, 2), last=(7, 7)),
    ],
)
field = rsegen.build(recipe, 0)           # integer levels in cells
rsegen.generate(recipe, "worlds")         # a Gazebo world and model package

Public names are those that the core and the capabilities declare (`rsegen/params/capabilities.py`). Each is imported
when it is first used (PEP 562), so `import rsegen` takes no time; `__init__.pyi`, made from the declarations, says the
same to type checkers.
"""

import sys
from importlib import import_module

__version__ = "1.0.0"


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, and describe its parameters; `__all__` has all names."""
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module 'rsegen' has no attribute {name!r}")
    declared = import_module("rsegen.params.capabilities")
    if name == "__all__":
        return ["__version__", *sorted(declared.public_names())]
    home = declared.home_of(name)
    if not home:
        raise AttributeError(f"module 'rsegen' has no attribute {name!r}")
    value: object = getattr(import_module(home), name)
    globals()[name] = value = import_module("rsegen.params.docstrings").described(value)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *import_module("rsegen.params.capabilities").public_names()})


if "IPython" in sys.modules:  # a notebook, perhaps: fields and scenes are shown as small plans
    for register in import_module("rsegen.params.capabilities").hooks("notebook"):
        register()
