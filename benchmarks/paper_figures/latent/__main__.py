"""Figures 4 to 8 of the latent paper; see `benchmarks.latent.figures`, which they are.

python -m benchmarks.paper_figures.latent --figures 4 --draws 20
"""

from __future__ import annotations

from benchmarks.latent.figures import main

if __name__ == "__main__":
    main()
