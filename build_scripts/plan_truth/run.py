"""How often a planned campaign names what it says it names: virtual campaigns, and the real diagnosis.

    python build_scripts/plan_truth/run.py -o plan_truth --hours 1 --share 0.2

A plan is made as `pipeclamp plan -o` makes it. It says above which rms force 90 % of the effects are named. Each of
them is hidden in the base law, that large, half and twice as large; the virtual rig runs the plan, the base law is
identified, and `diagnose` is asked. The rig scatters nothing from run to run but amplitude and temperature, so that the
plan is made for none.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from pathlib import Path

import numpy as np
import polars as pl

import pipeclamp as pc
from pipeclamp_identification.campaign.drive import FULL_CYCLES, RAMP_CYCLES
from pipeclamp_identification.campaign.rig.plan import RigRun, TestPlan, planned
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.planning.campaign import CampaignPlan, PlanRequest, plan_campaign
from pipeclamp_identification.planning.hidden import law_of_size
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.catalogue import effect_id

LAW = "emwm2"
SIZES = (0.5, 1.0, 2.0)
"""Times the size above which the plan says that 90 % of the effects are named."""


def case(plan: CampaignPlan, effect: str, newtons: float, seed: int) -> tuple[str, list[str]]:
    """Hide an effect of so many N rms, and give the verdict and the effects that it names."""
    law = law_of_size(open_law(LAW), effect, newtons, plan.power.scene.grid)
    runs = [
        RigRun(run.run, run.amplitude_mm, run.frequency_Hz, run.temperature_C, run.first_cycle) for run in plan.runs
    ]
    rig = TestPlan(cycles=FULL_CYCLES, ramp_cycles=RAMP_CYCLES, force_noise=plan.asked.noise_N, seed=seed)
    with tempfile.TemporaryDirectory(prefix="pipeclamp_plan_") as name:
        folder = Path(name) / "tests"
        write_campaign(folder, virtual_runs(law, planned(rig, runs)), name="planned", notes="", format="parquet")
        tests = pc.read_campaign(folder)
        found = pc.diagnose(pc.identify(tests), tests)
        return found.verdict, [effect_id(one) for one in found.effects]


def main() -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the table")
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--limits", default="A=0.2..1,f=1..5,T=20..20")
    parser.add_argument("--share", type=float, default=1.0, help="of the effects, chosen by --seed")
    parser.add_argument("--seed", type=int, default=1)
    told = parser.parse_args()
    told.output.mkdir(parents=True, exist_ok=True)
    plan = plan_campaign(open_law(LAW), parse_limits(told.limits), PlanRequest(hours=told.hours, scatter=0.0))
    least, names = plan.power.from_newtons, np.array(plan.power.scene.effects)
    print(f"{len(plan.runs)} runs, {plan.hours:.3g} h, {least:.3g} N", flush=True)
    known = np.flatnonzero(plan.power.told)
    chosen = np.random.default_rng(told.seed).permutation(known)[: math.ceil(told.share * len(known))]
    rows = []
    for place in sorted(chosen.tolist()):
        effect = str(names[place])
        for times in SIZES:
            begun = time.perf_counter()
            newtons = times * least
            try:
                verdict, effects = case(plan, effect, newtons, told.seed)
            except ValueError:  # no size of it has that force
                continue
            foretold = float(plan.power.chance(newtons)[place])
            rows.append(
                {
                    "effect": effect, "times": times, "newtons": newtons, "foretold": foretold, "verdict": verdict,
                    "effects": " ".join(effects), "named": verdict == "missing" and effects[:1] == [effect],
                    "seconds": time.perf_counter() - begun,
                }
            )  # fmt: skip
            print(rows[-1], flush=True)
            pl.from_dicts(rows).write_csv(told.output / "plan.csv")
    frame = pl.from_dicts(rows)
    for times in SIZES:
        own = frame.filter(pl.col("times") == times)
        print(f"{times:g} times: named {int(own['named'].sum())} of {len(own)}, foretold {own['foretold'].mean():.0%}")


if __name__ == "__main__":
    main()
