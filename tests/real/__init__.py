"""What rsegen writes, judged by the simulators that read it."""
