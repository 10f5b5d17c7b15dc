"""Work in threads of its own, so that the window never waits; results arrive as Qt signals."""
