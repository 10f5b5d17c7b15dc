"""What maps cost a simulator with robots in it: the paper's tables, by one command.

Plan --cells--> Cell --tried--> Outcome --kept--> results.jsonl --report--> table, CSV, plot
"""
