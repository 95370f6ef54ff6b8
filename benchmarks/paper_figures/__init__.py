"""The figures of the papers, made anew by mien."""
