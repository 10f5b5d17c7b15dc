"""Commands are killed, and their calls fail, at random calls: each unit is old or new, and nothing foreign changes."""
