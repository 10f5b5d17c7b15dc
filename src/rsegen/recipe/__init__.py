"""Recipes, which say what to generate, and the way from a recipe to a step field.

Recipe --build--> StepField
"""
