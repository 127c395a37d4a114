"""A law: its parameters with their uncertainty, its force, and its file."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pipeclamp.api.shown import PathOrName, file_of, html_table, path_of
from pipeclamp.show.law import coefficient_table, doubts, fit_words, vain_words
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law import bundled
from pipeclamp_models.law.file import LawFile, write_law
from pipeclamp_models.law.range import beyond_tests

if TYPE_CHECKING:
    from pipeclamp_models.base.tables import pl


class Law:
    """A law as its parameter file holds it.

    Attributes:
        file: all that the parameter file says.
        origin: the file or the bundled name that it was read from, or last saved to; else the name of the law's file.

    >>> open_law("emwm2").effects
    ('damping_temperature', 'contact_growth', 'stiffness_frequency')
    """

    def __init__(self, file: LawFile, origin: str | None = None, *, steps: int = 1) -> None:
        """Hold a file, from an origin; so many of the last steps of its history were taken at once.

        Raises:
            UserError: it is not what a parameter file says, as a file's name.
        """
        if not isinstance(file, LawFile):
            raise UserError(f"Law: got {file!r}; expected what a law's file says: open_law reads it of a file's name")
        self.file = file
        self._steps = steps
        self.origin = origin or f"{file.name}.json"
        self._kept = origin is not None

    @property
    def is_kept(self) -> bool:
        """Whether `origin` holds it: it was read from there, or saved."""
        return self._kept

    @property
    def name(self) -> str:
        """The law's name."""
        return self.file.name

    @property
    def base(self) -> str:
        """Name of the base law: power, memory or series."""
        return self.file.base

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added to the base, in order."""
        return self.file.effects

    @property
    def values(self) -> dict[str, float]:
        """Value of each parameter by name; units in `to_frame`."""
        return {name: entry.value for name, entry in self.file.coefficients.items()}

    @property
    def nrmse(self) -> float | None:
        """Error on the tests that it was fitted to, as a share of the rms force; None where it wasn't fitted."""
        return self.file.fit.nrmse if self.file.fit else None

    def force(
        self,
        y: npt.ArrayLike,
        v: npt.ArrayLike,
        *,
        A: npt.ArrayLike | None = None,
        f: npt.ArrayLike | None = None,
        T: npt.ArrayLike | None = None,
        h: float | None = None,
        **conditions: npt.ArrayLike,
    ) -> Array | np.float64:
        """Give the clamp's force along a motion; effects of the rig stay out, as in the FMU.

        Where the law has memory, y is the motion from rest, sample by sample along its last axis; without memory the
        order doesn't matter. Conditions beyond the law's tests are told by a warning.

        Args:
            y: displacement in mm, shape (..., n) or a number.
            v: velocity in mm/s, of a shape that broadcasts with it.
            A: amplitude of the motion in mm, where the law follows it; shapes as v.
            f: its frequency in Hz, likewise.
            T: temperature in °C, likewise; of no use where the law's tests told none.
            h: seconds between samples, where the law has memory: it then goes from sample to sample as an FMU through
                its step, and unloads from where the motion turned between two of them; without h each is one straight
                move. Laws whose memory fades with time (`relaxation`) ask for it.
            conditions: further ones by the column's name in runs.csv: density_g_cm3, first_cycle, current_A.

        Returns:
            force in N, positive with positive displacement, of the shape that y and v have together.

        Raises:
            UserError: a condition that the law follows isn't given, or one that it doesn't know is.

        Source:
            Eq. 17 of Symmetry 2020, 12(8), 1283 for the base `power`; `pipeclamp effects` for the effects.

        >>> float(round(open_law("emwm2").force(0.5, 0.0, A=0.5, f=3.0, T=20.0)))
        885.0
        """
        from pipeclamp_models.realise.along import force_along

        given = {"A": A, "f": f, "T": T}
        known: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        known |= conditions
        force = force_along(self.file, y, v, known, h)
        for words in beyond_tests(self.file, known):
            warnings.warn(f"law.force: {words}; nothing shows its force there", stacklevel=2)
        return force

    def save(self, path: PathOrName) -> Path:
        """Write the parameter file, whole or not at all, and give its path.

        Raises:
            UserError: it can't be written there.
        """
        target = file_of(path)
        write_law(self.file, target)
        self.origin = str(path)
        self._kept = True
        return target

    def to_dict(self) -> dict[str, Any]:
        """Give the parameter file as dicts, lists, text, numbers; `pipeclamp schema` gives its schema."""
        return self.file.model_dump(by_alias=True, exclude_none=True, mode="json")

    def to_frame(self) -> pl.DataFrame:
        """Give a row a parameter: value, standard error, unit, state, meaning."""
        from pipeclamp_models.base.tables import pl

        rows = [
            {
                "parameter": name, "value": entry.value, "standard_error": entry.standard_error, "unit": entry.unit,
                "state": entry.state, "meaning": entry.meaning, "reason": entry.reason,
            }
            for name, entry in self.file.coefficients.items()
        ]  # fmt: skip
        return pl.from_dicts(rows, infer_schema_length=None)

    def report(self, path: PathOrName) -> Path:
        """Write the law's page, whole or not at all: how its error fell, equations, parameters, surfaces.

        Raises:
            UserError: it can't be written there.
        """
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.sections import law_alone_page

        target = file_of(path)
        made_of = " + ".join((self.base, *self.effects))
        write_report(target, f"Law {self.name}", made_of, law_alone_page(self.file, self._steps))
        return target

    def __repr__(self) -> str:
        """Give name, base and effects."""
        return f"<law {self.name}: {' + '.join((self.base, *self.effects))}>"

    def __str__(self) -> str:
        """Say what the law is, how well it fits, and what the last step did."""
        lines = [f"{self.name}: {' + '.join((self.base, *self.effects))}"]
        if self.file.fit:
            lines[0] += f"; {fit_words(self.file.fit)}"
        return "\n".join([*lines, *self._history(), *doubts(self.file)])

    def _history(self) -> Sequence[str]:
        """Say what each step did to the error on left-out conditions, and where the last addition doesn't help."""
        known = [step for step in self.file.history if step.refitted_nrmse is not None]
        vain = vain_words(self.file.history, self._steps)
        return [
            *(f"{step.step}: error on left-out conditions {step.refitted_nrmse:.2%}" for step in known),
            *([f"{vain}."] if vain else []),
        ]

    def _repr_html_(self) -> str:
        """Give what a notebook shows."""
        from html import escape

        lines = "".join(f"<p>{escape(line)}</p>" for line in str(self).splitlines())
        return lines + html_table(coefficient_table(self.file))


def open_law(law: PathOrName) -> Law:
    """Open a law by the path of its file, or by the name of a bundled one.

    Raises:
        UserError: there is no such law, or the file isn't one.

    >>> open_law("emwm2")
    <law emwm2: power + damping_temperature + contact_growth + stiffness_frequency>
    """
    origin = path_of(law, "a law")
    return Law(bundled.open_law(origin), origin)


def opened(law: Law | PathOrName) -> Law:
    """Give a law as it is, or open it."""
    return law if isinstance(law, Law) else open_law(law)
