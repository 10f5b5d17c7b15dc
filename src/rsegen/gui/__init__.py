"""The window: a recipe made and looked at with the mouse. `session` knows no Qt."""
