"""What the window works on, without Qt: the recipe being edited, its preview, and the jobs that write files."""
