"""How the strength of a term follows a condition, in other forms than the power or exponential it was found with.

So that all terms may be enumerated, each is scaled in one way. Once a scaled term is found, others can be asked for in
its place: an exponential, from a level on, up to one, levelling off, setting in about a level, fading about one. Each
is a factor >= 0 of what stays the same along a cycle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from pipeclamp_identification.discovery.conditions import (
    LEVEL,
    SCALED,
    Followed,
    Scale,
    followed_signal,
    scales_of,
)
from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, Term, id_of
from pipeclamp_identification.discovery.shapes import RATE, STRENGTH, Entry, scaling
from pipeclamp_models.law.declaration import Declaration

START_WIDTH = 0.15
"""Of the condition's range, where fits begin."""


@dataclass(frozen=True)
class Following:
    """A form in which a strength follows a condition.

    Attributes:
        name: as ids have it.
        factor: >= 0.
        words: what it is.
        parameters: of the factor.
    """

    name: str
    factor: str
    words: str
    parameters: tuple[Entry, ...]


def followed_otherwise(term: Term, varied: Sequence[str], conditions: Mapping[str, float]) -> Iterator[Term]:
    """Give a scaled term in each other form in which it may follow its condition; that form's parameters are its last.

    Args:
        term: the term; none is given of one that isn't scaled, or is a factor itself.
        varied: of A, f and T those that vary over the tests.
        conditions: further columns that vary, with the largest magnitude of each.
    """
    known = [(name, one) for name, one in SCALED.items() if name in varied]
    known += [(name, one) for name, size in conditions.items() for one in scales_of(name, size)]
    for signal, scale in known:
        scaled = f"{STRENGTH} * {scale.factor}"
        if scaled not in (term.declaration.force or ""):
            continue
        for form in _forms(followed_signal(signal, conditions)):
            if len(term.declaration.parameters) - 1 + len(form.parameters) <= MOST_PARAMETERS:
                yield _following(term, scale, form)


def _forms(followed: Followed) -> Iterator[Following]:
    """Give the forms in which a strength may follow a signal."""
    plain, name = followed.symbol, followed.name
    if not followed.column:  # a further column is scaled so to begin with
        yield Following("exponential", f"exp({RATE} * {followed.pure})", f"exponentially with the {name}",
                        (scaling(f"by how much it follows the {name}", -0.5, 0.5),))  # fmt: skip
    level: Entry = {"symbol": LEVEL, "unit": followed.unit, "meaning": f"level of the {name} about which it changes",
             "start": followed.bends}  # fmt: skip
    turned = f"{followed.past} / sqrt(1 + ({followed.past})**2)"
    yield Following(
        "beyond", f"(max({plain} - {LEVEL}, 0) / {followed.step})", f"from a level of the {name} on", (level,)
    )
    yield Following("below", f"(max({LEVEL} - {plain}, 0) / {followed.step})", f"up to a level of the {name}", (level,))
    if plain != "T":  # what is far from zero levels off nowhere
        yield Following("levelling", f"(abs({plain}) / (abs({plain}) + abs({LEVEL})))",
                        f"with the {name} and levelling off", (level,))  # fmt: skip
    about = ({**level, **followed.within_tests}, followed.steepness(START_WIDTH, START_WIDTH))
    yield Following("setting_in", f"((1 + {turned}) / 2)", f"setting in about a level of the {name}", about)
    yield Following("fading", f"((1 - {turned}) / 2)", f"fading about a level of the {name}", about)


def _following(term: Term, scale: Scale, form: Following) -> Term:
    """Give a term with another form in the place of what scales it."""
    old = term.declaration
    acts_like = term.acts_like.replace(f", scaled with {scale.words}", f", {form.words}")

    def changed(text: str) -> str:
        return text.replace(f"{STRENGTH} * {scale.factor}", f"{STRENGTH} * {form.factor}")

    declaration = Declaration.model_validate({
        **old.model_dump(exclude_defaults=True),
        "id": id_of(f"{old.id.removeprefix('found_')}_{form.name}"), "title": acts_like, "looks_like": acts_like,
        "parameters": (
            *({**one.model_dump(), "start": one.start[:1]} for one in old.parameters if one.symbol != RATE),
            *form.parameters,
        ),
        "force": changed(old.force or ""), "energy": changed(old.energy) if old.energy else old.energy,
    })  # fmt: skip
    return Term(term.family, declaration, acts_like, term.shorter)
