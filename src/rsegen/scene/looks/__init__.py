"""Textures of blocks: images that repeat, made of numbers alone, the same pixels on every machine."""
