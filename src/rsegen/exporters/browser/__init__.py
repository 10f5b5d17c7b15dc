"""Maps as a page for browsers: one HTML file with 3D view, plan, metrics and recipe, which needs no internet.

The page is page.html with its style and scripts, which are files of this folder, and the maps as JSON. Names and
recipes may have any letters: in the HTML they are escaped, in the JSON there is no `<`, and the scripts set text as
text.
"""
