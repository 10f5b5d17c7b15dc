"""The window: shape a map with the mouse and see it; model (no Qt), workers, widgets and dialogs, the window on top."""
