"""A law, or several, held against tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import PathOrName, Shown, frame_of, several
from pipeclamp.api.tests import Tests, tested
from pipeclamp.show.view import View
from pipeclamp_identification.workflow.after_comparison import after_comparison
from pipeclamp_identification.workflow.tests import Held
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.toml_file import unknown

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_identification.comparison.compare import Comparison as HeldToRecords
    from pipeclamp_models.base.tables import pl


class Comparison(Shown):
    """How much a law errs against tests, and where.

    Attributes:
        law, tests: what was compared.

    >>> from pipeclamp import compare, read_campaign
    >>> compare("emwm2", read_campaign("emwm2_tables")).to_frame().columns[:2]
    ['run', 'nrmse']
    """

    def __init__(self, law: Law, tests: Tests, held: Held) -> None:
        self.law = law
        self.tests = tests
        self._held = held

    @property
    def nrmse(self) -> float:
        """Rms error over rms force, over all samples used; of metrics alone the rms log ratio of dW and W."""
        return self._held.nrmse

    @property
    def noise_nrmse(self) -> float | None:
        """The part of it that is cycle-to-cycle scatter, which no law can explain; None where it isn't known."""
        found: float | None = self.to_dict()["noise_nrmse"]
        return found

    @cached_property
    def _view(self) -> View:
        from pipeclamp.show.views import comparison_view

        with one_thread():
            return comparison_view(self._held)

    def view(self) -> View:
        """Give answer, tables and sentences, as `pipeclamp compare` tells them."""
        return self._view

    def page(self) -> Report:
        """Give the page, as `pipeclamp compare --report` writes it."""
        from pipeclamp.pages.page import Report
        from pipeclamp.pages.sections import comparison_page, comparison_title

        following = after_comparison(self.law.origin, self.tests.origin, self._held)
        sections = comparison_page([(self.law.file, self._held)], following)
        return Report(*comparison_title([self.law.file], self.tests.name), sections)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a run: its conditions (mm, Hz, °C), error and scatter as shares of the run's rms force."""
        return frame_of(self.to_dict()["runs"])

    def loop(self, run: str) -> pl.DataFrame:
        """Give a run's loop as measured and as the law gives it, to draw them: means over the cycles, at 256 phases.

        Args:
            run: its name in runs.csv, as in `to_frame`.

        Returns:
            a row a phase: phase_deg after the largest displacement, displacement_mm, velocity_mm_s, force_N as
            measured, law_force_N.

        Raises:
            UserError: there is no such run, its motion is no sine, or the tests are metrics alone.

        >>> from pipeclamp import compare
        >>> compare("emwm2", "clamp_a").loop("A1_f3_T20").columns
        ['phase_deg', 'displacement_mm', 'velocity_mm_s', 'force_N', 'law_force_N']
        """
        from pipeclamp_identification.comparison.drawn import drawn_run
        from pipeclamp_identification.comparison.laws import laws_held
        from pipeclamp_models.base.tables import pl

        held = self._held_to_records(run)
        sines = [each.run for each in held.runs]
        if run not in sines:
            if run in [each.run for each in held.free]:
                raise UserError(f"run {run!r}: its motion is no sine; expected a run of a sine, or .free_motion for it")
            raise UserError(unknown(run, sines, "run"))
        drawn = drawn_run(held.loops, laws_held([(self.law.file, held)]), sines.index(run))
        return pl.DataFrame(
            {
                "phase_deg": drawn.phase, "displacement_mm": drawn.y, "velocity_mm_s": drawn.v,
                "force_N": drawn.measured, "law_force_N": drawn.laws[0],
            }
        )  # fmt: skip

    def free_motion(self, run: str) -> pl.DataFrame:
        """Give a run of free motion as measured, and the law's force along it.

        Args:
            run: its name in runs.csv, as in `to_frame`.

        Returns:
            a row a sample: time_s from the record's beginning, displacement_mm and velocity_mm_s (smoothed), force_N as
            measured, law_force_N, and amplitude_mm and frequency_Hz as the law tracks them.

        Raises:
            UserError: there is no such run, its motion is a sine, or the tests are metrics alone.
        """
        from pipeclamp_models.base.tables import pl

        held = self._held_to_records(run)
        motions = {each.run: each for each in held.free}
        if run not in motions:
            if run in [each.run for each in held.runs]:
                raise UserError(f"run {run!r}: its motion is a sine; expected a run of free motion, or .loop for it")
            raise UserError(unknown(run, list(motions), "run of free motion"))
        found = motions[run]
        return pl.DataFrame(
            {
                "time_s": found.time, "displacement_mm": found.y, "velocity_mm_s": found.v,
                "force_N": found.measured, "law_force_N": found.computed,
                "amplitude_mm": found.amplitude, "frequency_Hz": found.frequency,
            }
        )  # fmt: skip

    def _held_to_records(self, run: str) -> HeldToRecords:
        from pipeclamp_identification.comparison import compare as records

        if not isinstance(self._held, records.Comparison):
            raise UserError(f"run {run!r}: these tests are metrics without records; expected records of the loops")
        return self._held

    def __repr__(self) -> str:
        """Give law, tests and error."""
        return f"<comparison of {self.law.name} with {self.tests.name}: error {self.nrmse:.2%}>"


@one_thread()
def compare(law: Law | PathOrName, tests: Tests | PathOrName) -> Comparison:
    """Hold a law against tests: how much it errs, and where.

    Runs of free motion (`motion = free` in runs.csv) count too: the law follows them from rest, A and f tracked as an
    FMU does; their scatter, and with it that of the whole, isn't known.

    Args:
        law: the law, or its file or bundled name.
        tests: the tests, or their folder or bundled name.

    Raises:
        UserError: the law follows a condition that the tests don't state.

    >>> from pipeclamp import read_campaign
    >>> compare("emwm2", read_campaign("emwm2_tables"))
    <comparison of emwm2 with emwm2_tables: error 0.91%>
    """
    if isinstance(law, str | PathLike) and Path(law).suffix == ".toml":
        raise UserError(f"compare: got {law}; expected a law: pc.compare_pipe holds a system against measurements")
    known, tests = opened(law), tested(tests)
    return Comparison(known, tests, tests.tests.compare(known.file))


class LawsComparison(Shown):
    """Several laws held against the same tests.

    Attributes:
        laws, tests: what was compared; sentences, and details of the page, are about the law that errs least.

    `compare_laws` makes one; its example shows what it holds.
    """

    def __init__(self, laws: Sequence[Law], tests: Tests, held: Sequence[Held]) -> None:
        self.laws = tuple(laws)
        self.tests = tests
        from pipeclamp_identification.comparison.names import named_apart

        files = named_apart([law.file for law in laws], [law.origin for law in laws])
        self._held = list(zip(files, held, strict=True))

    def view(self) -> View:
        """Give answer, table and sentences, as `pipeclamp compare` tells them."""
        from pipeclamp.show.views import laws_view

        with one_thread():
            return laws_view(self._held)

    def page(self) -> Report:
        """Give the page, as `pipeclamp compare --report` writes it."""
        from pipeclamp.pages.page import Report
        from pipeclamp.pages.sections import comparison_page, comparison_title
        from pipeclamp_identification.comparison.laws import least_error

        best = least_error([held for _, held in self._held])
        title = comparison_title([file for file, _ in self._held], self.tests.name)
        following = after_comparison(self.laws[best].origin, self.tests.origin, self._held[best][1])
        return Report(*title, comparison_page(self._held, following))

    def to_frame(self) -> pl.DataFrame:
        """Give a row a law: its name, what it is made of, and its error as a share of the rms force."""
        rows = [
            {"law": file.name, "made_of": " + ".join((file.base, *file.effects)), "nrmse": held.nrmse}
            for file, held in self._held
        ]
        return frame_of(rows)

    def __repr__(self) -> str:
        """Give the tests and each law's error."""
        errors = ", ".join(f"{file.name} {held.nrmse:.2%}" for file, held in self._held)
        return f"<comparison of laws with {self.tests.name}: {errors}>"


@one_thread()
def compare_laws(laws: Sequence[Law | PathOrName] | Mapping[str, Law], tests: Tests | PathOrName) -> LawsComparison:
    """Hold several laws against the same tests: which errs by how much, and what each leaves over.

    Args:
        laws: the laws, or their files or bundled names; also laws by name, as `identify_per` gives them.
        tests: the tests, or their folder or bundled name.

    Raises:
        UserError: there is no law, or one follows a condition that the tests don't state.

    >>> from pipeclamp import read_campaign
    >>> compare_laws(["published_R1", "emwm2"], read_campaign("clamp_a")).to_frame().columns
    ['law', 'made_of', 'nrmse']
    """
    each = laws.values() if isinstance(laws, Mapping) else several(laws)
    known, tests = [opened(law) for law in each], tested(tests)
    if not known:
        raise UserError("compare_laws: got no law; expected one at least")
    return LawsComparison(known, tests, [tests.tests.compare(law.file) for law in known])
