"""How a law came about, for the page inside its FMU: the error step by step, and how well it fits."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp_fmu.describe.documentation import Bar, Bars, DocumentedSection
from pipeclamp_models.law.file import FitQuality, HistoryStep

HEADING = "How the law came about"


def history_section(history: Sequence[HistoryStep], fit: FitQuality | None) -> DocumentedSection:
    """Give the section: a waterfall of the error, and the fit's quality in words; empty where the law says neither.

    The waterfall is of the error on left-out conditions where every step states it, else of that on the runs used.
    """
    return DocumentedSection(HEADING, _quality(fit), bars=_waterfall(history, fit.noise_nrmse if fit else None))


def _waterfall(history: Sequence[HistoryStep], noise: float | None) -> Bars | None:
    if not history:
        return None
    foretold = [step.refitted_nrmse for step in history if step.refitted_nrmse is not None]
    whole = len(foretold) == len(history)
    levels = foretold if whole else [step.nrmse for step in history]
    longest = max(*levels, noise or 0.0, 1e-300)
    befores = [levels[0], *levels[:-1]]
    rows = [
        Bar(
            step.step,
            level / longest,
            before / longest,
            (_percent(step.nrmse), "–" if step.refitted_nrmse is None else _percent(step.refitted_nrmse)),
        )
        for step, level, before in zip(history, levels, befores, strict=True)
    ]
    where = "left-out conditions" if whole else "the runs used"
    caption = f"Error of the force on {where}, as a share of its rms; light: what the step took away"
    mark = None if noise is None else noise / longest
    scatter = "" if noise is None else f"; line: {_percent(noise)} of scatter, which no law can explain"
    return Bars(f"{caption}{scatter}.", ("step", "runs used", "left out"), rows, mark)


def _quality(fit: FitQuality | None) -> tuple[str, ...]:
    if fit is None:
        return ()
    noise = "" if fit.noise_nrmse is None else f", of which {_percent(fit.noise_nrmse)} is scatter"
    words = [f"Against its own data the law errs by {_percent(fit.nrmse)} of the rms force{noise}."]
    if fit.runs:
        worst = max(fit.runs, key=lambda run: run.nrmse)
        words.append(f"Of its {len(fit.runs)} runs the worst is {worst.run}, with {_percent(worst.nrmse)}.")
    return (" ".join(words),)


def _percent(share: float) -> str:
    return f"{100 * share:.3g}\N{NO-BREAK SPACE}%"
