"""How right the results are, against known truths: `python -m benchmarks.accuracy`."""
