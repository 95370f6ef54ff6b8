"""The benchmark: every method on the same performances and characters, in one table."""
