"""A window on recipes and their maps."""
