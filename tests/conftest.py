"""How hypothesis runs: without a clock, for machines are noisy; and in CI the same examples every time."""

import os

from hypothesis import settings

settings.register_profile("house", deadline=None, derandomize=os.environ.get("CI") == "true")
settings.load_profile("house")
