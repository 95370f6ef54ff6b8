"""Learning from few labels, on real performances, beside the methods a reader would try first."""
