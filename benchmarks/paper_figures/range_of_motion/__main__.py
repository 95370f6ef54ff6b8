"""Table 1 and figures 7, 8 and 12 to 17 of the range-of-motion paper.

python -m benchmarks.paper_figures.range_of_motion --quick
python -m benchmarks.paper_figures.range_of_motion --out figures --data /path/to/data
"""

from __future__ import annotations

from benchmarks.paper_figures.range_of_motion.comparison import comparison
from benchmarks.paper_figures.range_of_motion.mouths import mouths
from benchmarks.paper_figures.range_of_motion.priors import main as compare_priors
from benchmarks.paper_figures.range_of_motion.shapes import shapes
from benchmarks.paper_figures.range_of_motion.similarity import likeness
from benchmarks.paper_figures.range_of_motion.timings import timings
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.faces import Settings


def priors(settings: Settings) -> None:
    """Make figure 14."""
    compare_priors(settings.out, settings.data)


if __name__ == "__main__":
    run(__doc__, timings, likeness, comparison, priors, mouths, shapes)
