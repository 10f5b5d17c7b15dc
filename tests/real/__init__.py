"""Files of rsegen, judged by the simulators that read it."""
