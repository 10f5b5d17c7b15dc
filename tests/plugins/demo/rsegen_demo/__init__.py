"""One plug-in of each sort, as somebody else's package has them."""
