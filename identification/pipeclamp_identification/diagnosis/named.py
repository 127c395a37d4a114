"""What a diagnosis names: how it is meant, and what of it was tried on the same tests in vain."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Literal

from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import InVain, LawFile

Kind = Literal["cause", "part"]
"""A cause explains what is missing, and its form fits; a part takes so much of it, and something that acts alike may
stand behind it."""

NO_PROOF = "a part is no proof: something else that acts alike may stand behind it"
FURTHER_TESTS = "tests at further conditions would tell whether it is real"


def tried_in_vain(
    effects: Sequence[str], file: LawFile, fingerprint: str, declared: Collection[Declaration] = ()
) -> str:
    """Say that all effects that a diagnosis names were tried in vain; empty where one is new, or the tests are.

    Args:
        effects: what the diagnosis names.
        file: the law.
        fingerprint: of the tests.
        declared: a user's own effects: their files may have changed since.
    """
    known = in_vain_on(file, fingerprint, declared)
    if not effects or not known.keys() >= set(effects):
        return ""
    return in_vain_words([known[name] for name in effects])


def in_vain_on(file: LawFile, fingerprint: str, declared: Collection[Declaration] = ()) -> dict[str, InVain]:
    """Give what was tried in vain on tests, by effect; arguments as for `tried_in_vain`."""
    if file.diagnosis is None or file.data.fingerprint != fingerprint:
        return {}
    own = {declaration.id for declaration in declared}
    return {one.effect: one for one in file.diagnosis.in_vain if one.effect not in own}


def in_vain_words(tried: Sequence[InVain]) -> str:
    """Say what was tried in vain, and what would tell more."""
    return f"{'; '.join(map(no_help, tried))}; {FURTHER_TESTS}"


def no_help(tried: InVain) -> str:
    """Say that an effect was tried, and what the error did."""
    without, having = tried.refitted_nrmse
    if having < without:  # by less than is worth an effect
        return f"{tried.effect} went, for the law did as well without it ({having:.2%} -> {without:.2%})"
    return (
        f"{tried.effect} was tried and not added: the error on left-out conditions didn't fall "
        f"({without:.2%} -> {having:.2%})"
    )
