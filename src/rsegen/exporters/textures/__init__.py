"""Textures of blocks: images that repeat, made of numbers alone, the same pixels on every machine.

An image has TILES x TILES tiles, one per block, and is multiplied by the colour (tint) of a material. Nothing is
computed with sines or powers, whose last digits differ between machines.
"""
