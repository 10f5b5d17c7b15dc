"""Runs are killed and disks are full, at random moments: nothing may be lost, and going on must give the same bytes."""
