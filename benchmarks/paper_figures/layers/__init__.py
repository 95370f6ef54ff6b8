"""Figures 6 to 10 of Kholgade, Matthews, Sheikh (2011), on real performances and the built-in cast."""
