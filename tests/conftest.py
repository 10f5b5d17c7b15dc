"""How hypothesis runs: without a clock, for machines are noisy; and in CI the same examples every time.

And how programs hear of an end: a shell that runs the tests behind its back has them ignore Ctrl-C, nohup has them
ignore that their terminal is gone, and all that they start would do so too.
"""

import os
import signal

from hypothesis import settings

settings.register_profile("house", deadline=None, derandomize=os.environ.get("CI") == "true")
settings.load_profile("house")

for _name, _usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    if hasattr(signal, _name) and signal.getsignal(getattr(signal, _name)) == signal.SIG_IGN:
        signal.signal(getattr(signal, _name), _usual)
