"""Discover a term, put it into the law, and take it back where the law with it doesn't hold."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from pipeclamp_identification.diagnosis.thresholds import MATERIAL_PART_SHARE
from pipeclamp_identification.discovery.discover import search
from pipeclamp_identification.discovery.guards import Guard, passive
from pipeclamp_identification.discovery.hearing import TermFound
from pipeclamp_identification.discovery.proposal import PowersBack, TermProposal, refused, renamed, with_fitted
from pipeclamp_identification.fitting.identify import software
from pipeclamp_identification.workflow.change import (
    LawChange,
    add_effect,
    stays_as_good,
    takes,
    with_powers_back,
    without_spare_powers,
    without_spares,
)
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Tests
from pipeclamp_models.base.digits import error_goes
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.law.catalogue import symbols_taken
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, NamedKind, Provenance, law_of
from pipeclamp_models.law.step import BeforeAfter


def discover(
    file: LawFile,
    tests: Tests,
    *,
    command: str,
    declared: Collection[Declaration] = (),
    workers: Workers = ALONE,
) -> TermProposal:
    """Find a term that a law lacks and no catalogue has, or say why none is proposed.

    Effects that the law does as well without, now that it has the term, go: a part may have stood for it. Where the law
    with the best term doesn't hold on all tests, what passed in another place is put in; where no term does, an effect
    of the catalogue that passes what a term is asked, as a part. Powers of the amplitude that the law's memory spared
    are fitted again first, for a term might stand for them, and are asked again last.

    Args:
        file: the law.
        tests: records of sines.
        command: the command that makes the law with the term again.
        declared: a user's own effects, which count as the catalogue's.
        workers: who does it, and who is told.

    Raises:
        UserError: the tests hold no records, or can't serve the law.
    """
    if not isinstance(tests, RecordTests):
        raise UserError(f"{tests.name}: metrics alone; expected a campaign with records, along which a term can act")
    freed = with_powers_back(file, tests, provenance=Provenance(command, file.date), progress=workers.tell)
    joining = _Joining(freed.after if freed else file, freed, tests, command, declared, workers)
    found = search(joining.law, tests.sines, tests.loops, declared=declared, workers=workers)
    noise = found.diagnosed.comparison.known_noise
    guards = found.found.guards if found.found else ()
    back = PowersBack(freed.step.freed, freed.heldout) if freed else None
    none = TermProposal(found, file, None, None, noise, None, guards, found.reason, (), powers_back=back)
    refusals = []
    for one in found.passed:
        blank = replace(none, search=replace(found, found=one), guards=one.guards)
        proposal = _put_in(one, blank, joining)
        if proposal.proposed:
            return proposal
        refusals.append(proposal)
    return _with_effect_instead(refusals[0] if refusals else none, joining)


@dataclass(frozen=True)
class _Joining:
    """What a term joins, and with what.

    Attributes:
        law: the law.
        freed: how it came by its powers of the amplitude again; None where none were spared.
        tests, command, declared, workers: as for `discover`.
    """

    law: LawFile
    freed: LawChange | None
    tests: RecordTests
    command: str
    declared: Collection[Declaration]
    workers: Workers

    def of(
        self,
        effect: str,
        *,
        start: Mapping[str, float],
        new: Collection[Declaration] = (),
        instead: Collection[str] = (),
        kind: NamedKind | None = None,
    ) -> tuple[list[LawChange], list[Guard]]:
        """Add a term or an effect to the law, fitted to all tests, and take out what is spare then.

        Returns:
            the steps; and what was asked of the law with it, which ends with the first that it doesn't pass.
        """
        tests, tell, provenance = self.tests, self.workers.tell, Provenance(self.command, self.law.date)
        added = add_effect(
            self.law, effect, tests,
            provenance=provenance, declared=(*self.declared, *new), kind=kind, start=start, instead=instead,
            progress=tell,
        )  # fmt: skip
        whole = _on_all_tests(added, beside=not instead)
        if not whole.passed:
            return [added], [whole]
        steps = [added, *without_spares(added.after, effect, tests, provenance=provenance, progress=tell)]
        if self.freed:
            spared = without_spare_powers(steps[-1].after, tests, complete=True, provenance=provenance, progress=tell)
            steps += [spared] if spared else []
        return steps, [whole, passive(steps[-1].after, self.law)]

    def left_out_errors(self, steps: Sequence[LawChange]) -> BeforeAfter:
        """Give the error on left-out conditions of the law as it was given, and after the last of some steps."""
        return BeforeAfter((self.freed or steps[0]).heldout.before, steps[-1].heldout.after)


def _put_in(best: TermFound, proposal: TermProposal, joining: _Joining) -> TermProposal:
    """Put a term that passed into a law, fitted to all tests; take it back where the law with it doesn't hold.

    Args:
        best: the term.
        proposal: nothing proposed, after the search that found it.
        joining: the law that it joins.
    """
    joining.workers.tell("refit with the term to all tests")
    asked, values = best.term.declaration, dict(best.judged.result.law.values)
    term = renamed(asked, {*law_of(joining.law).equations.names, *symbols_taken()})
    own = {new.symbol: values.pop(old.symbol) for old, new in zip(asked.parameters, term.parameters, strict=True)}
    steps, asked_last = joining.of(term.id, start={**values, **own}, new=[term], instead=best.gone)
    if not asked_last[-1].passed:
        return refused(proposal, asked_last[-1])
    law = steps[-1].after
    source = f"discovered from the tests {joining.tests.name} by {software()}: a formula that fits, no proof of a cause"
    declaration = with_fitted(term, law, source)
    others = tuple(one for one in law.declared if one.id != term.id)
    law = law.model_copy(update={"declared": (*others, declaration)})
    return replace(
        proposal, after=law, heldout=joining.left_out_errors(steps), declaration=declaration,
        guards=(*best.guards, *asked_last), spare=(*best.gone, *_gone(steps)),
    )  # fmt: skip


def _with_effect_instead(none: TermProposal, joining: _Joining) -> TermProposal:
    """Put an effect of the catalogue into a law, as a part, where one passed and it holds on all tests."""
    one = none.search.instead
    if one is None:
        return none
    joining.workers.tell(f"refit with {one.name} to all tests")
    steps, asked_last = joining.of(one.name, start=one.judged.result.law.values, kind="part")
    if not asked_last[-1].passed:
        return none
    return replace(
        none, after=steps[-1].after, heldout=joining.left_out_errors(steps), spare=_gone(steps), instead=one.name,
        guards=(*one.guards, *asked_last),
    )  # fmt: skip


def _gone(steps: Sequence[LawChange]) -> tuple[str, ...]:
    """Give the effects that went after a term joined."""
    return tuple(name for change in steps[1:] for name in change.step.gone)


def _on_all_tests(added: LawChange, *, beside: bool) -> Guard:
    """Ask whether a law does better with a term on all tests; by a material part, as an effect, where it stands beside.

    What stands in the place of effects may do as well as these with fewer parameters, as a law that loses a spare one.
    """
    before, after = added.heldout
    words = f"on left-out conditions of all tests {error_goes(before, after)}"
    falls, material = after < before, not beside or takes([added], MATERIAL_PART_SHARE)
    shorter = len(added.after.coefficients) < len(added.before.coefficients)
    if not beside and not falls and shorter and stays_as_good(added):
        return Guard("on all tests", True, f"{words}: as well with fewer parameters")
    little = f": less than {MATERIAL_PART_SHARE:.0%} of what is missing there (mean square beyond scatter)"
    return Guard("on all tests", falls and material, words if material or not falls else words + little)
