"""Learning and using the shared latent space: training, one frame, a clip, and the curve to 2000 unlabelled rows.

    python -m benchmarks.speed.latent
    python -m benchmarks.speed.latent --quick

The data are made: 99 markers and 50 parameters driven by smooth random expressions of 20
independent movements, with 0.5 % noise.  Training is timed to the gradient that is stated;
compilation happens before the clock starts.  One thread throughout, and its processor time is
what is given, so that other work on the machine does not count.

GPy has no model that learns from unlabelled frames; where it is installed, its manifold relevance
determination (MRD, variational, 30 inducing points, 200 iterations) learns from the 40 labels
alone, beside ours that does (`sgplvm`).
"""

from __future__ import annotations

import argparse
import importlib
import time
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, publish
from mien.core.arrays import Floats
from mien.retargeting.latent import LatentModel, LearntLatent
from mien.retargeting.samples import Samples, samples

LABELS = 40
MODELS = {
    "paper": LatentModel(),
    "paper, to a gradient of 1e-2": LatentModel(gradient=1e-2),
    "floor and principal start": LatentModel(floor=1e-3, beginning="principal"),
}


def performance(frames: int, seed: int = 0) -> tuple[Floats, Floats]:
    """Return markers `(F, 297)` and parameters `(F, 50)` of a made take at 60 frames a second."""
    rng = np.random.default_rng(seed)
    maps = np.random.default_rng(99)
    times = np.arange(frames)[:, None] / 60
    waves = np.sin(times * rng.uniform(0.3, 2, 20) + rng.uniform(0, 6, 20))
    acts = np.maximum(waves, 0) * 0.8 ** np.arange(20)
    bent = np.column_stack([acts, acts**2, acts * np.roll(acts, 1, axis=1)])
    x = bent @ maps.normal(size=(60, 297))
    y = np.tanh(bent @ maps.normal(size=(60, 50)))
    return x + rng.normal(0, 0.005 * x.std(), x.shape), y


def drawn(count: int) -> tuple[Samples, Floats]:
    """Return 40 labels and `count` unlabelled rows of either side, and a clip of 2000 frames."""
    x, y = performance(LABELS + 2 * count + 4000)
    order = np.random.default_rng(1).permutation(len(x))
    a, b, c = np.split(order[: LABELS + 2 * count], [LABELS, LABELS + count])
    return samples(x[a], y[a], x[b], y[c]), performance(2000, 2)[0]


def trained(model: LatentModel, given: Samples) -> tuple[LearntLatent, float]:
    begin = time.process_time()
    learnt = model.learn(given)
    return learnt, time.process_time() - begin


def row(name: str, count: int, model: LatentModel) -> Row:
    given, clip = drawn(count)
    learnt, seconds = trained(model, given)
    learnt.map(clip[:3])
    begin = time.process_time()
    learnt.map(clip)
    whole = time.process_time() - begin
    times, state = [], learnt.start()
    for x in clip[:500]:
        begin = time.process_time()
        state, _ = learnt.step(state, x)
        times.append(time.process_time() - begin)
    return {
        "model": name,
        "unlabelled": f"{count} + {count}",
        "training cpu s": round(seconds, 3),
        "iterations": learnt.convergence.iterations,
        "relative gradient": float(f"{learnt.convergence.gradient:.2g}"),
        "frame cpu ms, median": round(1000 * float(np.median(times)), 4),
        "2000 frames cpu s": round(whole, 3),
    }


def peer() -> list[Row]:
    """Time GPy on the labels alone, if it is there."""
    try:
        gpy: Any = importlib.import_module("GPy")
    except ImportError:
        print("GPy is not installed; its row is left out.")
        return []
    given, _ = drawn(0)
    begin = time.process_time()
    model = gpy.models.MRD([given.X_labelled, given.Y_labelled], 8, num_inducing=30, initx="PCA_concat")
    model.optimize("lbfgsb", max_iters=200)
    seconds = time.process_time() - begin
    return [
        {"model": "GPy MRD, labels alone", "unlabelled": "0", "training cpu s": round(seconds, 3), "iterations": 200}
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="only 100 unlabelled rows, and a curve to 500")
    quick = parser.parse_args().quick
    rows = []
    with threadpool_limits(limits=1):
        row("warm", 20, LatentModel(iterations=5))
        rows += [row(name, 100, model) for name, model in MODELS.items()]
        rows += [row("sgplvm, labels alone", 0, LatentModel(unlabelled=False)), *peer()]
        counts = [125, 250, 500] if quick else [125, 250, 500, 1000, 2000]
        sparse = LatentModel(floor=1e-3, beginning="principal", inducing=60, iterations=100, gradient=1e-12)
        curve = [row("60 inducing points, 100 iterations", count, sparse) for count in counts]
    seconds = [float(r["training cpu s"]) / max(int(r["iterations"]), 1) for r in curve]
    exponent = float(np.polyfit(np.log(counts), np.log(seconds), 1)[0])
    rows += curve
    about = (
        f"The shared latent space; seconds per iteration grow as the number of unlabelled rows to the {exponent:.2f}."
    )
    publish("speed_latent_quick" if quick else "speed_latent", about, rows, ["numpy", "scipy", "numba"])


if __name__ == "__main__":
    main()
