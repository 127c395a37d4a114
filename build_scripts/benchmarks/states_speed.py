"""What a law with states takes to be evaluated with its derivatives, against the bare law, in one process.

`python build_scripts/benchmarks/states_speed.py [CAMPAIGN]`; without a campaign the bundled clamp_a. Each law is
evaluated on all runs at as many points of a cycle as rough fits take; it has been evaluated once before, so that its
equations are known and its machine code is made. The least of twenty counts.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.observations import coarser, loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations

LAWS = (
    (), ("memory",), ("memory:3",), ("slip_spread",), ("bouc_wen",), ("play",), ("relaxation_spread",), ("oil_damper",),
    ("bouc_wen", "slip_spread"), ("memory:4", "oil_damper"),
)  # fmt: skip
TIMES = 20


def main() -> None:
    """Print a table: ms an evaluation, and times the bare law's."""
    loops = loops_of(read_campaign(campaign_folder(Path(sys.argv[1] if len(sys.argv) > 1 else "clamp_a"))))
    observations = loop_observations(loops)
    motion = coarser(loops, observations).motion
    bare = fit_structure(Structure("power"), loops, observations).law
    print(f"{motion.y.shape[0]} runs, {motion.y.shape[1]} points of a cycle; ms with derivatives, times the bare law")
    first = 0.0
    for effects in LAWS:
        structure = Structure("power", effects)
        values = starting_points(structure, observations, bare.values)[0]
        vector = [values[name] for name in structure.equations.names]
        taken = []
        for _ in range(1 + TIMES):
            begin = time.perf_counter()
            force_of_equations(structure.equations, vector, (bare.v_r, bare.y_r), motion, derivatives=True)
            taken.append(time.perf_counter() - begin)
        least = min(taken[1:])
        first = first or least
        print(f"{' + '.join(effects) or 'power':25} {1e3 * least:7.2f} {least / first:6.1f}")


if __name__ == "__main__":
    main()
