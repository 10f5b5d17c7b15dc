"""What rsegen costs, measured beside what others do."""
