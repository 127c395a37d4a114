"""A found term as a proposal: its declaration with fitted values, the law with it, and the answer for --json."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import Literal, NamedTuple

import tomli_w
from pydantic import Field

from pipeclamp_identification.discovery.discover import TermSearch
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import TermFound
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.law.declaration import Declaration, ParameterTable
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.law.range import rounded
from pipeclamp_models.law.step import BeforeAfter


class GuardAnswer(AnswerModel):
    """One thing that was asked of a term."""

    asked: str
    passed: bool
    words: str


class RivalAnswer(AnswerModel):
    """A term that does as well, or does so in draws of the conditions."""

    formula: str
    acts_like: str


class NumberAnswer(AnswerModel):
    """A parameter of the best term, fitted."""

    symbol: str
    meaning: str
    value: float
    standard_error: float | None = Field(description="of the value; None where the tests determine none")
    at_bound: bool = Field(description="whether the value is as far as it may go")
    unit: str = Field(description="- where it has none")


class DiscoveryAnswer(AnswerModel):
    """The answer of `pipeclamp discover --json`."""

    proposed: bool
    effect: str | None = Field(description="id of the proposed effect, as its declaration has it")
    formula: str | None = Field(description="what the term adds, with its fitted values; of the best term at least")
    acts_like: str | None = Field(description="what it does, in words; no cause that the tests can't show")
    numbers: tuple[NumberAnswer, ...] = Field(description="the best term's parameters, as fitted")
    family: Literal["spring", "damper", "element", "factor"] | None
    heldout_before: float | None = Field(description="error on left-out groups of A and f, as a share of the force")
    heldout_after: float | None = Field(description="the same with the term")
    noise_nrmse: float | None = Field(description="cycle-to-cycle scatter, which no law can explain")
    rivals: tuple[RivalAnswer, ...] = Field(
        description="terms that do as well, on these conditions or in a tenth of draws of them"
    )
    guards: tuple[GuardAnswer, ...] = Field(
        description="what was asked of the best term, or of the effect in its place, and with which figures"
    )
    tried: int = Field(description="terms that were evaluated")
    reason: str = Field(description="why nothing is proposed; empty where something is")
    caution: str | None = Field(description="what isn't to be trusted of the best term, in words")
    next_test: str | None = Field(
        description="the test that would tell the term from its rivals, in words; null where none does"
    )
    left_over: tuple[str, ...] = Field(
        description="where the rest lies, where neither a term nor an effect is given; most important first"
    )
    spare: tuple[str, ...] = Field(description="effects that went: the law does as well without them, with the term")
    instead: str | None = Field(
        description="effect of the catalogue, as `add` takes it, that passes what a term is asked where no term does; "
        "a part, no proof"
    )


class PowersBack(NamedTuple):
    """Powers of the amplitude that the law's memory had spared, and were fitted again before the search.

    Attributes:
        names: of the parameters.
        heldout: error on left-out groups without and with them, of all tests.
    """

    names: tuple[str, ...]
    heldout: BeforeAfter


@dataclass(frozen=True)
class TermProposal:
    """What a search came to, with the law that has the term.

    Attributes:
        search: the search.
        before: the law without the term.
        after: the law with it, or with the effect in its place, refitted to all tests; None where neither is proposed.
        heldout: error on left-out groups before and after, of all tests.
        noise_nrmse: the scatter; None where it isn't known.
        declaration: the proposed effect, with its fitted values to start from.
        guards: what was asked of the best term, or of the effect in its place.
        reason: why nothing is proposed; empty where something is.
        spare: effects that went, for the law does as well without them, now that it has the term.
        instead: an effect of the catalogue that the law has in the place of a term; empty where there is none.
        powers_back: what the law had gone without; None where it had all powers.
    """

    search: TermSearch
    before: LawFile
    after: LawFile | None
    heldout: BeforeAfter | None
    noise_nrmse: float | None
    declaration: Declaration | None
    guards: tuple[Guard, ...]
    reason: str
    spare: tuple[str, ...]
    instead: str = ""
    powers_back: PowersBack | None = None

    @property
    def proposed(self) -> bool:
        """Whether a term is."""
        return self.declaration is not None

    @property
    def found(self) -> TermFound | None:
        """The best term, whether it passed or not."""
        return self.search.found

    def answer(self) -> DiscoveryAnswer:
        """Give the typed answer."""
        found = self.found
        return DiscoveryAnswer(
            proposed=self.proposed,
            effect=self.declaration.id if self.declaration else None,
            formula=self.formula(),
            acts_like=found.term.acts_like if found else None,
            numbers=self.numbers(),
            family=found.term.family if found else None,
            heldout_before=self.heldout.before if self.heldout else None,
            heldout_after=self.heldout.after if self.heldout else None,
            noise_nrmse=self.noise_nrmse,
            rivals=tuple(
                RivalAnswer(formula=formula_of(rival.declaration), acts_like=rival.acts_like)
                for rival in (found.rivals if found else ())
            ),
            guards=tuple(GuardAnswer(asked=one.name, passed=one.passed, words=one.words) for one in self.guards),
            tried=self.search.tried,
            reason=self.reason,
            caution=found.caution or None if found else None,
            next_test=found.next_test or None if found else None,
            left_over=self.left_over(),
            spare=self.spare,
            instead=self.instead or None,
        )

    def left_over(self) -> tuple[str, ...]:
        """Say where the rest lies, where a term was sought and none is proposed."""
        nothing = self.after is None
        return self.search.diagnosed.left_over() if nothing and self.search.tried else ()

    def best(self) -> Declaration | None:
        """Give the best term as it is proposed, or as it was searched; None where there is none."""
        if self.declaration is not None or self.found is None:
            return self.declaration
        return self.found.term.declaration

    def numbers(self) -> tuple[NumberAnswer, ...]:
        """Give the best term's parameters as they are fitted; none where there is none."""
        declaration = self.best()
        if declaration is None or self.found is None:
            return ()
        if self.after is None or self.instead:
            fit = self.found.judged.result
            values, at_bound = fit.law.values, set(fit.at_bound)
            errors: Mapping[str, float | None] = fit.standard_errors()
        else:
            entries = self.after.coefficients
            values = {name: entry.value for name, entry in entries.items()}
            errors = {name: entry.standard_error for name, entry in entries.items()}
            at_bound = {name for name, entry in entries.items() if entry.state == "at_bound"}
        return tuple(
            NumberAnswer(
                symbol=one.symbol,
                meaning=one.meaning,
                value=values[one.symbol],
                standard_error=errors.get(one.symbol),
                at_bound=one.symbol in at_bound,
                unit=one.unit,
            )
            for one in declaration.parameters
        )

    def formula(self) -> str | None:
        """Give the best term's formula with its fitted values; None where there is none."""
        declaration = self.best()
        if declaration is None:
            return None
        fitted = (f"{one.symbol} = {one.value:.4g} {one.unit}".removesuffix(" -") for one in self.numbers())
        return f"{formula_of(declaration)}, with {', '.join(fitted)}"


def formula_of(declaration: Declaration) -> str:
    """Give what a term adds or scales, and how its state moves."""
    parts = [f"F += {declaration.force}"] if declaration.force else []
    parts += [f"{one.coefficient} *= {one.factor}" for one in declaration.scales]
    parts += [f"{one.symbol} = {one.update}" for one in declaration.states]
    parts += [f"y counted from {declaration.about_mm:g} mm"] if declaration.about_mm else []
    return _without_first_powers("; ".join(parts))


def _without_first_powers(text: str) -> str:
    """Leave out exponents of one, which the grammar writes where another one may be asked for."""
    return re.sub(r"\)\*\*1(?![.\w])", ")", text)


def renamed(declaration: Declaration, taken: Collection[str]) -> Declaration:
    """Give a term of the grammar with symbols that nothing has yet: F_1, F_2, ... for F_x.

    A law may hold several discovered terms, and the grammar's own symbols stay free for the next search.

    Args:
        declaration: the term.
        taken: the law's symbols, and the catalogue's, whose effects may join it later.
    """
    symbols = [*(one.symbol for one in declaration.parameters), *(one.symbol for one in declaration.states)]
    number = next(n for n in count(1) if not {f"{name[:-1]}{n}" for name in symbols} & set(taken))
    pattern = rf"\b(?:{'|'.join(name[:-1] for name in symbols)})x\b"
    text = re.sub(pattern, lambda found: f"{found[0][:-1]}{number}", declaration.model_dump_json())
    return Declaration.model_validate_json(_without_first_powers(text))


def with_fitted(declaration: Declaration, file: LawFile, source: str) -> Declaration:
    """Give a declaration that starts from a law's fitted values, and says where it comes from."""
    tables = tuple(_started(table, file.coefficients[table.symbol].value) for table in declaration.parameters)
    return declaration.model_copy(update={"parameters": tables, "source": source})


def _started(table: ParameterTable, value: float) -> ParameterTable:
    return table.model_copy(update={"start": (rounded(value),)})


def toml_of(declaration: Declaration) -> str:
    """Give a declaration as a file that a person can read, change and rename."""
    content = declaration.model_dump(mode="json", exclude_defaults=True)
    for table in content["parameters"]:
        starts = table["start"]
        table["start"] = starts[0] if len(starts) == 1 else list(starts)
    return tomli_w.dumps(content)


def refused(proposal: TermProposal, guard: Guard) -> TermProposal:
    """Take a proposal back, for a guard that it doesn't pass."""
    words = f"{proposal.found.term.acts_like if proposal.found else 'the term'}: {guard.words}"
    return replace(proposal, after=None, heldout=None, declaration=None, guards=(*proposal.guards, guard), reason=words)
