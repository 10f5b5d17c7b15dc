"""The model of the window, without Qt: the recipe being edited, its preview, and the jobs that write files."""
