"""The cost of maps for a simulator with robots in it: the paper's tables, by one command.

Plan --cells--> Cell --tried--> Outcome --noted--> journal --report--> table, CSV, plot
"""
