"""What to generate, and how a recipe becomes a step field.

Recipe --build--> StepField
"""
