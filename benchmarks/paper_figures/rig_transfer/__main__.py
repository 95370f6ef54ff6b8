"""All figures of the rig-transfer paper.

python -m benchmarks.paper_figures.rig_transfer --quick
python -m benchmarks.paper_figures.rig_transfer --out figures --data /path/to/data
"""

from __future__ import annotations

from benchmarks.paper_figures.rig_transfer.attributes import attributes
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.correspondence import correspondence
from benchmarks.paper_figures.rig_transfer.decimated import decimated
from benchmarks.paper_figures.rig_transfer.elsewhere import elsewhere
from benchmarks.paper_figures.rig_transfer.expressions import expressions
from benchmarks.paper_figures.rig_transfer.structure import structure

if __name__ == "__main__":
    run(__doc__, correspondence, structure, expressions, attributes, decimated, elsewhere)
