"""Figures 4 to 8 of Bouaziz and Pauly 2014."""
