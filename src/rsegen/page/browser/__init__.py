"""Maps as a page for browsers: one HTML file with 3D view, plan, metrics and recipe, which needs no internet."""
